//! Pictures that are drawn in the background, some of them roughly.

use super::*;
use crate::session::Order;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

#[test]
fn pictures_are_drawn_once_and_bad_ones_say_why() {
    let atelier = Atelier::new(subject(
        "let r = param(\"r\", 0.5, 0.1..1.0); if r > 0.9 { throw \"too large\" } sphere(r)",
    ));
    let draw = |id: usize, r: f64| {
        let (sender, drawn) = channel();
        let tell = move |drawn: Drawn| sender.send(drawn).unwrap();
        let ticket = atelier.ask(
            ((id, (24, 18)), Grade::Finished),
            of(&BTreeMap::from([("r".to_owned(), r.into())])),
            tell,
        );
        let drawn = drawn.recv().unwrap();
        drop(ticket);
        drawn
    };
    let first = draw(1, 0.5).unwrap();
    assert!(first.png.starts_with(b"\x89PNG") && Arc::ptr_eq(&first.png, &draw(1, 0.5).unwrap().png));
    assert_ne!(first.png, draw(2, 0.8).unwrap().png);
    assert!(draw(3, 0.95).unwrap_err().message.contains("too large"));
}

/// How far the colours of two pictures are apart, on average.
fn apart(a: &[u8], b: &[u8]) -> f64 {
    let [a, b] = [a, b].map(|png| image::load_from_memory(png).unwrap().into_rgb8());
    assert_eq!(a.dimensions(), b.dimensions());
    let off = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b)));
    off.sum::<f64>() / a.as_raw().len() as f64
}

#[test]
fn who_has_no_patience_gets_a_rough_picture_and_who_has_gets_all_of_it() {
    // What is seen roughly, and what is not: through a lens, that is, and at a sea.
    for more in
        ["", ", camera: orbit(#{ distance: 4.0, aperture: 0.02 })", ", sea: sea(#{ surface: y + 0.5 })"]
    {
        let script = format!("scene(#{{ surface: sphere(param(\"r\", 0.5, 0.1..1.0)){more} }})");
        let subject = subject(&script);
        let order = Order { size: Some((200, 150)), samples: Some(1), ..Order::default() };
        let genome = of(&BTreeMap::from([("r".to_owned(), 0.9.into())]));
        let sketch = |patience: Duration| {
            let stop = Arc::new(AtomicBool::new(false));
            let (png, finished) = subject.sketch(&genome, &order, (patience, &stop)).unwrap().unwrap();
            assert!(!(finished && stop.load(Ordering::SeqCst)));
            (png, finished)
        };
        let whole = subject.draw(&genome, &order, &Arc::default()).unwrap().unwrap();
        assert_eq!(sketch(Duration::from_secs(3600)), (whole.clone(), true), "{more}");
        let (rough, finished) = sketch(Duration::ZERO);
        let other = subject.draw(&Genome::default(), &order, &Arc::default()).unwrap().unwrap();
        assert!(!finished && rough != whole, "{more}");
        assert!(apart(&rough, &whole) < 0.5 * apart(&other, &whole), "{more}");
    }
}

#[test]
fn sketches_can_be_stopped() {
    let subject = subject("sphere(param(\"r\", 0.5, 0.1..1.0))");
    let order = Order { size: Some((200, 150)), ..Order::default() };
    let stopped = Arc::new(AtomicBool::new(true));
    let sketch = subject.sketch(&Genome::default(), &order, (Duration::ZERO, &stopped));
    assert!(sketch.is_err() || sketch.is_ok_and(|sketch| sketch.is_none()));
}

#[test]
fn rough_pictures_make_way_for_finished_ones() {
    let atelier = Atelier::new(subject("sphere(param(\"r\", 0.5, 0.1..1.0))"));
    let draw = |grade: Grade| {
        let (sender, drawn) = channel();
        let _ticket = atelier
            .ask(((0, (200, 150)), grade), Genome::default(), move |drawn| sender.send(drawn).unwrap());
        drawn.recv().unwrap().unwrap()
    };
    let [first, finished, last] = [Grade::Rough, Grade::Finished, Grade::Rough].map(draw);
    assert_eq!((finished.grade, last.grade), (Grade::Finished, Grade::Finished));
    assert!(Arc::ptr_eq(&finished.png, &last.png));
    // A small one is finished in a moment, and then it is not drawn again.
    assert_eq!(first.grade == Grade::Finished, Arc::ptr_eq(&first.png, &finished.png));
}

#[test]
fn what_nobody_waits_for_is_not_drawn() {
    let atelier = Atelier::new(subject("sphere(param(\"r\", 0.5, 0.1..1.0))"));
    let (sender, drawn) = channel();
    for id in 0..20 {
        let sender = sender.clone();
        let large = atelier
            .ask(((id, (4000, 3000)), Grade::Finished), Genome::default(), move |_| sender.send(id).unwrap());
        drop(large);
    }
    let (done, end) = channel();
    let _ticket =
        atelier.ask(((99, (8, 6)), Grade::Rough), Genome::default(), move |_| done.send(()).unwrap());
    end.recv().unwrap();
    drop((sender, atelier));
    assert_eq!(drawn.iter().count(), 0);
}
