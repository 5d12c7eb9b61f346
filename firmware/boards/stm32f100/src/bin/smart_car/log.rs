//! Logs on RTT (feature `defmt-rtt`): slots that were skipped, and readings that are missing.

use certainty_core::schedule::Activity;
use certainty_core::transducer::Reading;
use certainty_firmware::board::Board;
use certainty_firmware::executive::{Application, Due, Timeliness};
use certainty_firmware::smart_car::SmartCar;
use defmt_rtt as _;

defmt::timestamp!("{=u32:ms}", crate::clock::ticks());

/// The car, watched.
pub(crate) struct Logged<'a, B: Board>(pub(crate) &'a mut SmartCar<B>);

impl<B: Board> Application for Logged<'_, B> {
    fn perform(&mut self, activity: Activity, due: Due, timeliness: Timeliness) {
        self.0.perform(activity, due, timeliness);
        if let Activity::Read(sensor) | Activity::Measure(sensor) = activity
            && let Some(Reading::Missing(reason)) = self.0.reading(sensor)
        {
            defmt::warn!("sensor {}: no reading: {}", sensor.number(), reason);
        }
    }

    fn skip(&mut self, activity: Activity, due: Due) {
        defmt::warn!(
            "round {}: slot {} skipped: {}",
            due.round,
            due.slot,
            activity
        );
        self.0.skip(activity, due);
    }
}
