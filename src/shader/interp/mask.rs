//! Which lanes of a block are active.

/// The most lanes of a block, which is the most invocations of a workgroup.
pub(super) const MOST_LANES: usize = 1024;
/// The lanes that are active, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Mask([u64; MOST_LANES / 64]);

impl Mask {
    pub(super) const NONE: Self = Mask([0; MOST_LANES / 64]);

    pub(super) fn first(lanes: usize) -> Self {
        let mut mask = Mask::NONE;
        for (index, word) in mask.0.iter_mut().enumerate() {
            *word = match lanes.saturating_sub(64 * index) {
                0 => 0,
                64.. => u64::MAX,
                rest => (1 << rest) - 1,
            };
        }
        mask
    }
    pub(super) fn any(&self) -> bool {
        self.0.iter().any(|word| *word != 0)
    }
    pub(super) fn with(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(word, other)| *word |= other);
        self
    }
    pub(super) fn without(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(word, other)| *word &= !other);
        self
    }
    pub(super) fn holds(&self, lane: usize) -> bool {
        self.0.get(lane / 64).is_some_and(|word| word >> (lane % 64) & 1 == 1)
    }
    pub(super) fn set(&mut self, lane: usize) {
        if let Some(word) = self.0.get_mut(lane / 64) {
            *word |= 1 << (lane % 64);
        }
    }
    /// The active lanes whose word satisfies a condition.
    pub(super) fn filtered(&self, words: &[u32], f: impl Fn(u32) -> bool) -> Self {
        let mut mask = Mask::NONE;
        for ((to, from), words) in mask.0.iter_mut().zip(self.0).zip(words.chunks(64)) {
            if from != 0 {
                let bits = words.iter().enumerate().fold(0, |bits, (bit, word)| bits | u64::from(f(*word)) << bit);
                *to = bits & from;
            }
        }
        mask
    }
    /// Copies the active lanes.
    pub(super) fn copy<T: Copy>(&self, to: &mut [T], from: &[T]) {
        for ((word, to), from) in self.0.iter().zip(to.chunks_mut(64)).zip(from.chunks(64)) {
            match *word {
                0 => {}
                u64::MAX => to.copy_from_slice(from),
                word => {
                    for (bit, (to, from)) in to.iter_mut().zip(from).enumerate() {
                        if word >> bit & 1 == 1 {
                            *to = *from;
                        }
                    }
                }
            }
        }
    }
    pub(super) fn lanes(self) -> impl Iterator<Item = usize> {
        self.0
            .into_iter()
            .enumerate()
            .flat_map(|(index, word)| (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| 64 * index + bit))
    }
}
