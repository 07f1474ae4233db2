use brdf::batch::*; use brdf::layered::*; use brdf::plan::Plan; use brdf::Vector;
use std::time::Instant;
fn main(){ let n: usize=std::env::args().nth(1).and_then(|x|x.parse().ok()).unwrap_or(3968);
 let mut s=12345u64; let mut rnd=||{s=s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);((s>>40) as f64)/((1u64<<24) as f64)};
 let mut l=[vec![0f32;n],vec![0f32;n],vec![0f32;n]]; let mut v=l.clone(); let mut o=l.clone();
 for i in 0..n{ for d in [&mut l,&mut v]{ let z=0.02+0.98*rnd(); let p=6.283185307*rnd(); let r=(1.0-z*z).sqrt(); d[0][i]=(r*p.cos()) as f32;d[1][i]=(r*p.sin()) as f32;d[2][i]=z as f32;}}
 let cu=Interface::conductor([0.213f64,1.04,1.17],[4.05,2.59,2.36],0.3);
 let coat=Layer::new(Interface::dielectric(1.5,0.1));
 for (name,layers) in [("cu",vec![Layer::new(cu)]),("coat cu",vec![coat,Layer::new(cu)]),("tinted cu",vec![coat.over([0.1,0.2,0.3],0.5),Layer::new(cu)]),("coat lambert",vec![coat,Layer::new(Interface::diffuse([0.5,0.4,0.3],0.0))]),("coat oren",vec![coat,Layer::new(Interface::diffuse([0.5,0.4,0.3],0.3))])] {
 for err in [0.0,1e-6,2e-5] {
  let st=Stack::<f64,3>::new(Model::Conserving,layers.clone()).unwrap(); let p=Plan::with_error(&st,err).unwrap();
  for level in Level::available(){ let mut best=f64::MAX; for _ in 0..(if n<10000{2000}else{6}){ let t=Instant::now(); for _ in 0..4 {let [a,b,c]=&mut o; p.evaluate_batch_at(level,[&l[0],&l[1],&l[2]],[&v[0],&v[1],&v[2]],[a,b,c]).unwrap();} best=best.min(t.elapsed().as_secs_f64());}
   let mut worst=0f64; let exact=Plan::new(&st).unwrap(); for i in 0..n.min(4000){ let (a,b)=(Vector::new(l[0][i],l[1][i],l[2][i]),Vector::new(v[0][i],v[1][i],v[2][i])); let w:[f64;3]=exact.evaluate(a.cast::<f64>(),b.cast::<f64>()); for c in 0..3 { if w[c]>1e-8 { worst=worst.max((o[c][i] as f64/w[c]-1.0).abs()/1.19e-7);} } }
   let mut vb=f64::MAX; for _ in 0..(if n<10000{500}else{3}){ let t=Instant::now(); for _ in 0..4 {let [a,b,c]=&mut o; p.evaluate_view_at(level,[&l[0],&l[1],&l[2]],Vector::new(0.3,0.4,0.866),[a,b,c]).unwrap();} vb=vb.min(t.elapsed().as_secs_f64());}
   println!("{name:12} err {err:.0e} {:9} {:7.1} Meval/s  view {:7.1}  worst {:.1} eps",level.name(),4.0*n as f64/best/1e6,4.0*n as f64/vb/1e6,worst); }
 }}
}
