//! Timing of every kind of correction on small pictures.

use super::gl::{Sampling, Trial, TrialMesh};
use super::vk;
use std::path::Path;

#[test]
fn every_kind_of_pass_is_timed() {
    let mut trial = Trial::new((64, 32)).unwrap();
    trial.add_mesh(&TrialMesh::quad(), &Sampling::Picture(64, 32)).unwrap();
    trial.add_mesh(&TrialMesh::quad(), &Sampling::Cube(16)).unwrap();
    let formula = |body: &str| Sampling::Formula(body.into(), Box::new(Sampling::Cube(16)));
    trial.add_mesh(&TrialMesh::quad(), &formula("return at - 0.5;")).unwrap();
    assert!(trial.add_mesh(&TrialMesh::quad(), &formula("nonsense")).is_err());
    let places = trial.coordinates(&TrialMesh::quad(), &formula("return 2.0 * at;")).unwrap();
    // The third pixel of the second row.
    assert_eq!(places[64 + 2], [5.0 / 64.0, 2.0 * 30.5 / 32.0, 0.0, 1.0]);
    trial.fill(0, &[vec![0xff40_4040; 64 * 32]]).unwrap();
    assert!(trial.picture(0).unwrap().iter().all(|pixel| *pixel == [0x40, 0x40, 0x40, 255]));
    trial.fill(1, &vec![vec![0xff20_2020; 16 * 16]; 6]).unwrap();
    assert!(trial.fill(0, &[vec![0; 3]]).is_err() && trial.fill(1, &[vec![0; 256]]).is_err());
    assert!(trial.picture(9).is_err());
    let mut rounds = 0;
    let times = trial.run(3, || rounds += 1).unwrap();
    assert_eq!((times.len(), rounds), (3, 5));
    assert!(times.iter().all(|times| times.seconds.len() == 3 && times.seconds.iter().all(|time| *time > 0.0)));
}

#[test]
fn a_plan_is_timed() {
    let text = "[dome]\ntilt = 90\ncoverage = 360\n[views]\nmethod = \"single\"\n[[output]]\nkind = \"projector\"\n\
                position = [0, 0, 2.5]\nfov = [60, 40]\n";
    let rig = cupola::rig::parse(text, "trial.toml", Path::new("")).expect("a rig");
    let request = crate::planning::request(vec![(64, 40)], (64, 40));
    let plan = cupola::correct::build(&rig, &request).expect("a plan");
    let mut trial = vk::Trial::new((64, 40)).expect("a device");
    let number = trial.add_plan(&plan).expect("shaders");
    assert!(trial.time(number).expect("drawn") > 0.0);
    assert!(trial.map(&plan).expect("a map").iter().all(|pixel| pixel.view == Some(0)));
    assert!(trial.time(number + 1).is_err());
}
