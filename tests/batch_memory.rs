//! Batches allocate nothing: counted by the allocator of this test alone.

use brdf::batch::{self, terms};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;
static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every request goes to the system's allocator as it came.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn counted(run: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    run();
    ALLOCATIONS.load(Ordering::Relaxed) - before
}

// One test: another thread's allocations would be counted too.
#[test]
fn batches_allocate_nothing() {
    let count = 200_003;
    let cos: Vec<f32> = (0..count).map(|i| i as f32 / count as f32).collect();
    let (mut f, mut t) = (vec![0.0; count], vec![0.0; count]);
    let kernel = terms::Conductor { n: 1.04, k: 2.59 };
    assert!(counted(|| drop(vec![0u8; 64])) > 0, "the counter counts");
    let serial = counted(|| batch::map(&kernel, [&cos], [&mut f, &mut t]).expect("slices of one length"));
    assert_eq!(serial, 0);

    #[cfg(feature = "rayon")]
    {
        // Rayon starts its pool, and now and then adds a block to a queue, whatever the size of the work: not one a chunk.
        batch::par_map(&kernel, [&cos], [&mut f, &mut t]).expect("slices of one length");
        let least = (0..20)
            .map(|_| counted(|| batch::par_map(&kernel, [&cos], [&mut f, &mut t]).expect("slices of one length")))
            .min();
        assert!(least <= Some(2), "{least:?} allocations for {} chunks", count / batch::GRAIN);
    }
}
