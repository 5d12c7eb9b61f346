//! The time-triggered round: what is done when, as checked constant data.
//!
//! A round is a list of slots that is worked off again and again. Everything that a wrong list
//! could do to the readings is refused when the [`Schedule`] is built, which is before the program
//! is if the schedule is a constant: a head still swings when its sensor looks, a conversion is
//! read too early, two sensors see each other's light (\[000\] §3), a sensor never has its turn.
//!
//! A round is complete in itself: a sensor moves, measures and is fused in the same one, in this
//! order. The order of the `Fuse` slots is the order of updates, on which the robust grid's values
//! depend (\[001\] §7). Where the robot moves, the round steers after them, and gives the motors what was
//! decided in a slot of its own: when wheels change their speed must not depend on how long a decision took.
//!
//! Memory: 6 bytes a slot, 22 a sensor; of a constant they are in flash.

mod check;
mod error;
mod round;

pub use error::{MAX_STEPS, ScheduleError};
pub use round::{Activity, Aim, Measuring, ScheduleConfig, Signal, Slot, Station};

use crate::sensor::SensorId;

/// A round that keeps all rules; the checked [`ScheduleConfig`].
///
/// Possession proves, of every round:
/// - the slots follow one another, none overlaps the next, all end within the round, and the round
///   is no longer than a sensor may be silent;
/// - every sensor has its turn once: it is moved if it can be, started and read or measured, and
///   fused, in this order, and gets the time to settle and to convert;
/// - a round that steers, or that drives, does both and each once: it steers when all is fused, so that
///   control sees all that the round learned, and then drives;
/// - no two sensors of like signals ever look within [`ScheduleConfig::apart`] of each other while
///   one measures what the other sends, in any step of their sweeps; late echoes and those from the
///   round before included.
///
/// # Examples
///
/// Two infrared heads that measure at once, and a ranger. A schedule that breaks a rule is refused
/// with its reason:
///
/// ```
/// use certainty_core::schedule::{
///     Activity::{Fuse, Measure, Move, Read, Report, Start},
///     Aim, Measuring, Schedule, ScheduleConfig, ScheduleError, Signal, Slot, Station,
/// };
/// use certainty_core::sensor::SensorId;
/// use certainty_core::transducer::Sweep;
/// use certainty_core::units::BinaryAngle;
///
/// let id = |number| SensorId::new(number).ok_or("zero");
/// let (right, left, ranger) = (id(1)?, id(2)?, id(3)?);
/// let degrees = |d: i32| BinaryAngle::from_millidegrees(d * 1000);
/// let sweep = Sweep::try_new(degrees(-90), degrees(90), 37)?;
/// let head = |slot| Station {
///     signal: Signal::Light,
///     aim: Aim::Sweeping { sweep, slot, heads: 2, settle: 100 },
///     measuring: Measuring::Apart { conversion: 70 },
///     fades: 0,
/// };
/// let good = ScheduleConfig {
///     period: 250,
///     stale_after: 2000,
///     apart: degrees(20),
///     slots: [
///         Slot::new(0, 1, Move(right)),
///         Slot::new(1, 1, Move(left)),
///         Slot::new(10, 30, Measure(ranger)), // while the heads settle
///         Slot::new(40, 5, Fuse(ranger)),
///         Slot::new(102, 1, Start(right)),
///         Slot::new(103, 1, Start(left)),
///         Slot::new(175, 4, Read(right)),
///         Slot::new(179, 4, Read(left)),
///         Slot::new(183, 5, Fuse(right)),
///         Slot::new(188, 5, Fuse(left)),
///         Slot::new(193, 40, Report),
///     ],
///     stations: [
///         head(0),
///         head(1),
///         Station {
///             signal: Signal::Sound,
///             aim: Aim::Fixed(BinaryAngle::ZERO),
///             measuring: Measuring::Whole { longest: 30 },
///             fades: 40,
///         },
///     ],
/// };
/// let schedule = Schedule::try_new(good)?;
/// assert_eq!(schedule.due(175), Some(6));
/// assert!(schedule.fusion_order().eq([ranger, right, left]));
///
/// let mut hasty = good;
/// hasty.slots[4].at = 100;
/// let refused = Schedule::try_new(hasty);
/// assert_eq!(refused, Err(ScheduleError::Unsettled { slot: 4, sensor: right, ready: 101 }));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// As a constant it does not build:
///
/// ```compile_fail
/// use certainty_core::schedule::{Activity::Report, Schedule, ScheduleConfig, Slot};
/// use certainty_core::units::BinaryAngle;
///
/// const ROUND: Schedule<1, 0> = match Schedule::try_new(ScheduleConfig {
///     period: 10,
///     stale_after: 2000,
///     apart: BinaryAngle::ZERO,
///     slots: [Slot::new(0, 11, Report)], // 11 ms in a round of 10 ms
///     stations: [],
/// }) {
///     Ok(schedule) => schedule,
///     Err(error) => panic!("{}", error.reason()),
/// };
/// assert_eq!(ROUND.period(), 10);
/// ```
///
/// and with one millisecond less it does:
///
/// ```
/// # use certainty_core::schedule::{Activity::Report, Schedule, ScheduleConfig, Slot};
/// # use certainty_core::units::BinaryAngle;
/// #
/// # const ROUND: Schedule<1, 0> = match Schedule::try_new(ScheduleConfig {
/// #     period: 10,
/// #     stale_after: 2000,
/// #     apart: BinaryAngle::ZERO,
/// slots: [Slot::new(0, 10, Report)],
/// #     stations: [],
/// # }) {
/// #     Ok(schedule) => schedule,
/// #     Err(error) => panic!("{}", error.reason()),
/// # };
/// # assert_eq!(ROUND.period(), 10);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Schedule<const SLOTS: usize, const STATIONS: usize>(ScheduleConfig<SLOTS, STATIONS>);

impl<const SLOTS: usize, const STATIONS: usize> Schedule<SLOTS, STATIONS> {
    /// Checks a round.
    ///
    /// Cost: slots times stations, and for two sensors that measure at the same time the rounds
    /// after which their sweeps begin anew, at most [`MAX_STEPS`].
    ///
    /// # Errors
    ///
    /// [`ScheduleError`] names the first rule that is broken and by what: first the times of the
    /// slots, then what they are for, then each sensor's turn, then steering and driving, then what disturbs
    /// what.
    pub const fn try_new(config: ScheduleConfig<SLOTS, STATIONS>) -> Result<Self, ScheduleError> {
        match check::check(
            config.period,
            config.stale_after,
            config.apart,
            &config.slots,
            &config.stations,
        ) {
            Ok(()) => Ok(Self(config)),
            Err(error) => Err(error),
        }
    }

    /// Returns the milliseconds from the start of one round to the start of the next.
    #[must_use]
    pub const fn period(&self) -> u16 {
        self.0.period
    }

    /// Returns what is done, in the order of time.
    #[must_use]
    pub const fn slots(&self) -> &[Slot; SLOTS] {
        &self.0.slots
    }

    /// Returns the sensors, in the order of their numbers.
    #[must_use]
    pub const fn stations(&self) -> &[Station; STATIONS] {
        &self.0.stations
    }

    /// Returns what the schedule knows about `sensor`; `None` if it is not in it.
    #[must_use]
    pub fn station(&self, sensor: SensorId) -> Option<&Station> {
        self.0.stations.get(sensor.slot())
    }

    /// Returns the slot that begins at `tick_in_round`, in ms after the round's start, counted
    /// from 0; `None` if none does.
    ///
    /// Cost: a binary search, which an interrupt can afford every tick.
    #[must_use]
    pub fn due(&self, tick_in_round: u16) -> Option<usize> {
        self.0
            .slots
            .binary_search_by_key(&tick_in_round, |slot| slot.at)
            .ok()
    }

    /// Returns the sensors in the order in which their readings are fused in every round.
    pub fn fusion_order(&self) -> impl Iterator<Item = SensorId> + '_ {
        self.0.slots.iter().filter_map(|slot| match slot.activity {
            Activity::Fuse(sensor) => Some(sensor),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transducer::Sweep;
    use crate::units::BinaryAngle;

    const fn id(number: u8) -> SensorId {
        match SensorId::new(number) {
            Some(sensor) => sensor,
            None => panic!("zero"),
        }
    }

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    const fn sweep(directions: u16) -> Sweep {
        match Sweep::try_new(degrees(-90), degrees(90), directions) {
            Ok(sweep) => sweep,
            Err(_) => panic!("no such sweep"),
        }
    }

    const fn head(slot: u16, heads: u16) -> Station {
        Station {
            signal: Signal::Light,
            aim: Aim::Sweeping {
                sweep: sweep(37),
                slot,
                heads,
                settle: 100,
            },
            measuring: Measuring::Apart { conversion: 70 },
            fades: 0,
        }
    }

    const fn ranger(fades: u16) -> Station {
        Station {
            signal: Signal::Sound,
            aim: Aim::Fixed(BinaryAngle::ZERO),
            measuring: Measuring::Whole { longest: 30 },
            fades,
        }
    }

    const A: SensorId = id(1);
    const B: SensorId = id(2);
    const C: SensorId = id(3);
    const D: SensorId = id(4);

    /// Two heads that measure at once, 95° apart, and two rangers one after the other.
    const GOOD: ScheduleConfig<15, 4> = ScheduleConfig {
        period: 250,
        stale_after: 2000,
        apart: degrees(20),
        slots: [
            Slot::new(0, 1, Activity::Move(A)),
            Slot::new(1, 1, Activity::Move(B)),
            Slot::new(2, 30, Activity::Measure(C)),
            Slot::new(35, 5, Activity::Fuse(C)),
            Slot::new(62, 30, Activity::Measure(D)),
            Slot::new(92, 5, Activity::Fuse(D)),
            Slot::new(101, 1, Activity::Start(A)),
            Slot::new(102, 1, Activity::Start(B)),
            Slot::new(130, 10, Activity::Report),
            Slot::new(172, 4, Activity::Read(A)),
            Slot::new(176, 4, Activity::Read(B)),
            Slot::new(180, 5, Activity::Fuse(B)),
            Slot::new(185, 5, Activity::Fuse(A)),
            Slot::new(190, 10, Activity::Report),
            Slot::new(240, 10, Activity::Report),
        ],
        stations: [head(0, 2), head(1, 2), ranger(30), ranger(30)],
    };

    /// A constant is checked while the program is built.
    const BUILT: Schedule<15, 4> = match Schedule::try_new(GOOD) {
        Ok(schedule) => schedule,
        Err(error) => panic!("{}", error.reason()),
    };

    /// What a good round is refused with after `change`.
    fn refusal(change: impl FnOnce(&mut ScheduleConfig<15, 4>)) -> ScheduleError {
        let mut config = GOOD;
        change(&mut config);
        Schedule::try_new(config).unwrap_err()
    }

    #[test]
    fn a_good_round_is_accepted_and_says_what_is_due_when() {
        assert_eq!(Schedule::try_new(GOOD), Ok(BUILT));
        let due: Vec<_> = (0..BUILT.period())
            .filter_map(|tick| Some((tick, BUILT.due(tick)?)))
            .collect();
        let expected: Vec<_> = (0..).zip(GOOD.slots).map(|(i, s)| (s.at, i)).collect();
        assert_eq!(due, expected);
        assert_eq!(BUILT.station(D), Some(&ranger(30)));
        assert_eq!(BUILT.station(id(5)), None);
    }

    #[test]
    fn the_fusion_order_is_the_order_of_the_fuse_slots() {
        assert_eq!(BUILT.fusion_order().collect::<Vec<_>>(), [C, D, B, A]);
    }

    #[test]
    fn a_slot_takes_6_bytes_and_a_station_22() {
        assert_eq!(size_of::<Slot>(), 6);
        assert_eq!(size_of::<Station>(), 22);
    }

    #[test]
    fn a_round_without_slots_is_refused() {
        let empty = ScheduleConfig {
            period: 250,
            stale_after: 2000,
            apart: BinaryAngle::ZERO,
            slots: [],
            stations: [],
        };
        assert_eq!(Schedule::try_new(empty), Err(ScheduleError::NoSlots));
    }

    #[test]
    fn a_round_longer_than_a_sensor_may_be_silent_is_refused() {
        assert_eq!(
            refusal(|c| c.stale_after = 249),
            ScheduleError::RoundTooLong {
                period: 250,
                stale_after: 249
            }
        );
        let just_so = ScheduleConfig {
            stale_after: 250,
            ..GOOD
        };
        assert!(Schedule::try_new(just_so).is_ok());
    }

    #[test]
    fn more_stations_than_numbers_are_refused() {
        let slots = [Slot::new(0, 1, Activity::Report)];
        let stations = [ranger(0); 256];
        let crowd = ScheduleConfig {
            period: 250,
            stale_after: 2000,
            apart: BinaryAngle::ZERO,
            slots,
            stations,
        };
        assert_eq!(
            Schedule::try_new(crowd),
            Err(ScheduleError::TooManyStations)
        );
    }

    #[test]
    fn a_slot_without_time_is_refused() {
        assert_eq!(
            refusal(|c| c.slots[8].lasts = 0),
            ScheduleError::EmptySlot { slot: 8 }
        );
    }

    #[test]
    fn slots_out_of_order_are_refused() {
        let error = ScheduleError::OutOfOrder { slot: 9 };
        assert_eq!(refusal(|c| c.slots[9].at = 129), error);
        assert_eq!(refusal(|c| c.slots[9].at = 130), error, "two at once");
    }

    #[test]
    fn a_slot_that_overruns_the_next_is_refused() {
        assert_eq!(
            refusal(|c| c.slots[8].lasts = 43),
            ScheduleError::Overrun {
                slot: 8,
                end: 173,
                next: 172
            }
        );
    }

    #[test]
    fn a_slot_that_overruns_the_round_is_refused() {
        assert_eq!(
            refusal(|c| c.period = 249),
            ScheduleError::RoundOverrun {
                slot: 14,
                end: 250,
                period: 249
            }
        );
        let beyond_16_bits =
            refusal(|c| c.slots[14] = Slot::new(u16::MAX, u16::MAX, Activity::Report));
        assert!(matches!(
            beyond_16_bits,
            ScheduleError::RoundOverrun { end: 131_070, .. }
        ));
    }

    #[test]
    fn a_slot_for_an_unknown_sensor_is_refused() {
        assert_eq!(
            refusal(|c| c.slots[13].activity = Activity::Fuse(id(5))),
            ScheduleError::UnknownSensor {
                slot: 13,
                sensor: id(5)
            }
        );
    }

    #[test]
    fn a_sensor_is_not_told_to_do_what_it_cannot() {
        for activity in [
            Activity::Move(C),
            Activity::Start(C),
            Activity::Read(C),
            Activity::Measure(A),
        ] {
            assert_eq!(
                refusal(|c| c.slots[13].activity = activity),
                ScheduleError::NotItsKind { slot: 13, activity }
            );
        }
    }

    #[test]
    fn a_sensor_without_any_part_of_its_turn_is_refused() {
        for (slot, Slot { activity, .. }) in GOOD.slots.into_iter().enumerate() {
            if activity != Activity::Report {
                assert_eq!(
                    refusal(|c| c.slots[slot].activity = Activity::Report),
                    ScheduleError::NoTurn { activity }
                );
            }
        }
    }

    #[test]
    fn doing_the_same_twice_is_refused() {
        for (first, Slot { activity, .. }) in GOOD.slots.into_iter().enumerate() {
            if activity != Activity::Report {
                assert_eq!(
                    refusal(|c| c.slots[13].activity = activity),
                    ScheduleError::Twice {
                        activity,
                        first,
                        again: 13
                    }
                );
            }
        }
    }

    #[test]
    fn activities_in_the_wrong_order_are_refused() {
        let swapped = |a: usize, b: usize| {
            refusal(|c| {
                let activity = c.slots[a].activity;
                c.slots[a].activity = c.slots[b].activity;
                c.slots[b].activity = activity;
            })
        };
        let early = |slot, after| ScheduleError::WrongOrder { slot, after };
        assert_eq!(swapped(0, 6), early(0, 6)); // started, then moved
        assert_eq!(swapped(6, 9), early(6, 9)); // read, then started
        assert_eq!(swapped(9, 12), early(9, 12)); // fused, then read
        assert_eq!(swapped(2, 3), early(2, 3)); // fused, then measured
    }

    #[test]
    fn a_head_gets_its_time_to_settle_after_the_slot_that_moves_it() {
        assert_eq!(
            refusal(|c| c.slots[6].at = 100),
            ScheduleError::Unsettled {
                slot: 6,
                sensor: A,
                ready: 101
            }
        );
    }

    #[test]
    fn a_conversion_gets_its_70_ms() {
        assert_eq!(
            refusal(|c| c.slots[9].at = 171),
            ScheduleError::Unconverted {
                slot: 9,
                sensor: A,
                ready: 172
            }
        );
    }

    #[test]
    fn a_whole_measurement_fits_its_slot() {
        assert_eq!(
            refusal(|c| c.slots[2].lasts = 29),
            ScheduleError::TooShort {
                slot: 2,
                sensor: C,
                longest: 30
            }
        );
    }

    #[test]
    fn two_heads_that_measure_at_once_must_look_apart_in_every_step() {
        // 18 directions of 5° ahead: 90° apart, and 95° where the one has flown back already.
        let apart = |angle| {
            Schedule::try_new(ScheduleConfig {
                apart: angle,
                ..GOOD
            })
        };
        let least = sweep(37)
            .direction(18, 0, 2)
            .separation(sweep(37).direction(0, 0, 2));
        assert!(apart(least).is_ok());
        let wider = BinaryAngle::from_bits(least.to_bits() + 1);
        assert!(matches!(
            apart(wider),
            Err(ScheduleError::Interference {
                first: A,
                second: B,
                ..
            })
        ));
        // The one looks at 90° to the right and the other ahead: the first step will do.
        assert_eq!(
            refusal(|c| c.stations[1] = head(0, 2)),
            ScheduleError::Interference {
                first: A,
                second: B,
                step: 0
            }
        );
        // A fixed one 30° to the left is passed by in the step before 24 · 5° − 90° = 30°.
        let fixed = Station {
            aim: Aim::Fixed(degrees(30)),
            ..head(0, 1)
        };
        let passed = refusal(|c| {
            c.stations[1] = fixed;
            c.slots[1].activity = Activity::Report;
            c.apart = degrees(6);
        });
        assert_eq!(
            passed,
            ScheduleError::Interference {
                first: A,
                second: B,
                step: 23
            }
        );
    }

    #[test]
    fn unlike_signals_do_not_disturb_each_other() {
        let mut config = GOOD;
        config.stations[1] = head(0, 2);
        config.stations[1].signal = Signal::Sound;
        config.slots[1].activity = Activity::Move(B);
        config.stations[2].fades = 0;
        config.stations[3].fades = 0;
        assert!(Schedule::try_new(config).is_ok());
    }

    #[test]
    fn a_sound_that_has_not_faded_disturbs_the_next_ranger() {
        // C measures until 32 ms, D from 62 ms.
        assert_eq!(
            refusal(|c| c.stations[2].fades = 31),
            ScheduleError::Interference {
                first: C,
                second: D,
                step: 0
            }
        );
    }

    #[test]
    fn a_sound_that_has_not_faded_disturbs_the_next_round() {
        // D measures until 92 ms, C from 2 ms of the next round, which is 252 ms.
        let fading = |fades| {
            let mut config = GOOD;
            config.stations[3].fades = fades;
            Schedule::try_new(config)
        };
        assert!(fading(160).is_ok());
        assert_eq!(
            fading(161),
            Err(ScheduleError::Interference {
                first: C,
                second: D,
                step: 0
            })
        );
    }

    #[test]
    fn a_sound_fades_before_the_same_rangers_next_turn() {
        let alone = |fades| {
            Schedule::try_new(ScheduleConfig {
                period: 100,
                stale_after: 2000,
                apart: degrees(20),
                slots: [
                    Slot::new(0, 30, Activity::Measure(A)),
                    Slot::new(30, 5, Activity::Fuse(A)),
                ],
                stations: [ranger(fades)],
            })
        };
        assert!(alone(70).is_ok());
        assert_eq!(alone(71), Err(ScheduleError::StillFading { sensor: A }));
    }

    #[test]
    fn sweeps_that_meet_in_too_many_ways_are_refused() {
        let with = |directions: [u16; 2]| {
            let mut config = GOOD;
            for (station, directions) in config.stations.iter_mut().zip(directions) {
                let Aim::Sweeping { sweep: swept, .. } = &mut station.aim else {
                    unreachable!("the first two are heads");
                };
                *swept = sweep(directions);
            }
            config.apart = BinaryAngle::ZERO;
            Schedule::try_new(config)
        };
        assert!(with([255, 257]).is_ok()); // 65,535 rounds
        assert_eq!(
            with([256, 257]),
            Err(ScheduleError::TooManySteps {
                first: A,
                second: B,
                steps: 65_792
            })
        );
        assert!(with([30_000, 30_000]).is_ok());
    }

    /// The good round, which steers in slot 13 and drives in slot 14.
    const DRIVING: ScheduleConfig<15, 4> = {
        let mut config = GOOD;
        config.slots[13].activity = Activity::Steer;
        config.slots[14].activity = Activity::Drive;
        config
    };

    /// What a driving round is refused with after `change`.
    fn driving_refusal(change: impl FnOnce(&mut ScheduleConfig<15, 4>)) -> ScheduleError {
        let mut config = DRIVING;
        change(&mut config);
        Schedule::try_new(config).unwrap_err()
    }

    #[test]
    fn a_round_steers_and_drives_once_all_is_fused() {
        assert!(Schedule::try_new(DRIVING).is_ok());
        // Slot 12 fuses A: steering before it, control would not see what A saw.
        let early = driving_refusal(|c| {
            c.slots[12].activity = Activity::Steer;
            c.slots[13].activity = Activity::Fuse(A);
        });
        let after = ScheduleError::WrongOrder {
            slot: 12,
            after: 13,
        };
        assert_eq!(early, after);
    }

    #[test]
    fn driving_before_steering_is_refused() {
        let swapped = driving_refusal(|c| {
            c.slots[13].activity = Activity::Drive;
            c.slots[14].activity = Activity::Steer;
        });
        let after = ScheduleError::WrongOrder {
            slot: 13,
            after: 14,
        };
        assert_eq!(swapped, after);
    }

    #[test]
    fn steering_without_driving_and_driving_without_steering_are_refused() {
        for (dropped, activity) in [(13, Activity::Steer), (14, Activity::Drive)] {
            assert_eq!(
                driving_refusal(|c| c.slots[dropped].activity = Activity::Report),
                ScheduleError::NoTurn { activity }
            );
        }
    }

    #[test]
    fn steering_twice_is_refused() {
        for activity in [Activity::Steer, Activity::Drive] {
            let twice = driving_refusal(|c| c.slots[8].activity = activity);
            assert!(
                matches!(twice, ScheduleError::Twice { activity: told, .. } if told == activity)
            );
        }
    }

    #[test]
    fn a_refusal_says_which_and_what_to_do_in_one_line() {
        let refused = [
            refusal(|c| c.slots[9].at = 171),
            refusal(|c| c.slots[13].activity = Activity::Move(A)),
            refusal(|c| c.stations[1] = head(0, 2)),
        ];
        assert_eq!(
            refused.map(|error| error.to_string()),
            [
                "a sensor is read before its conversion is over: slot 9, sensor 1; begin it at 172 ms \
                 or later",
                "the same is done twice in a round: move sensor 1 in slots 0 and 13; drop one",
                "two sensors look the same way at the same time: sensors 1 and 2 in round 0; measure \
                 one after the other or shift a sweep",
            ]
        );
    }
}
