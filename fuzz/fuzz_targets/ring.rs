//! The diagnosis of a sonar ring on arbitrary readings.
//!
//! The first byte chooses where the scan ends and the echoes begin; four bytes are a beam, two an echo.
#![no_main]

use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Pose};
use certainty_ring::{
    Assessment, Distances, Echoes, INDEPENDENT_OVERLAPS, Monitor, PATHS_OF_A_SENSOR, Polygon,
    PolygonRules, Ring, RingConfig, RingRules, Scan, Scanner,
};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((&share, data)) = data.split_first() else {
        return;
    };
    let (beams, echoes) = data.split_at(data.len() * usize::from(share) / 256);
    let assessment = assess(beams, echoes);
    assert_eq!(assessment, assess(beams, echoes));
    let simulated = assessment.simulation_based();
    assert!(simulated.iter().all(|&paths| paths <= PATHS_OF_A_SENSOR));
    let meeting = assessment.intersection_based();
    assert!(meeting.iter().all(|&arcs| arcs <= INDEPENDENT_OVERLAPS));
    for (&sum, verdict) in assessment.overall().iter().zip(assessment.verdicts()) {
        assert_eq!(sum == 0, verdict.is_faulty());
    }
});

fn assess(beams: &[u8], echoes: &[u8]) -> Assessment<24> {
    let scanner = Scanner::try_new(Pose::default(), Millimeters::new(8000)).unwrap();
    let mut scan = Scan::<722>::new();
    for beam in beams.chunks_exact(4) {
        let bearing = BinaryAngle::from_bits(u16::from_le_bytes([beam[0], beam[1]]));
        if scan
            .add(&scanner, bearing, reading([beam[2], beam[3]]))
            .is_err()
        {
            assert_eq!(scan.points().len(), 722);
        }
    }
    let polygon = Polygon::<64>::of(&scan, &PolygonRules::DEFAULT);
    let polygon = polygon.unwrap_or(Polygon::empty());
    let ring = Ring::<24>::try_new(RingConfig::DEFAULT).unwrap();
    let mut received = Echoes::unknown();
    for (place, echo) in echoes.chunks_exact(2).enumerate() {
        let from = place / 7 % 24;
        let to = (from + place % 7 + 21) % 24;
        let ends = [from, to].map(|slot| SensorId::from_slot(slot).unwrap());
        received
            .set(ends[0], ends[1], reading([echo[0], echo[1]]))
            .unwrap();
    }
    let rules = RingRules::DEFAULT;
    let expected = Distances::simulated(&ring, &polygon);
    let folded = Distances::fold(&ring, &received, &rules);
    Monitor::new(rules).assess(&ring, Some(&expected), &folded)
}

fn reading(bytes: [u8; 2]) -> Reading {
    match u16::from_le_bytes(bytes) {
        0 => Reading::TooNear,
        1 => Reading::NoObject,
        2 => Reading::Missing(Missing::Timeout),
        mm => Reading::Echo(Millimeters::new(mm.into())),
    }
}
