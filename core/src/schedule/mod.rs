//! The time-triggered round: which activity begins when, as checked constant data.
//!
//! A round is a list of slots that repeats. A [`Schedule`] is a checked round: it refuses a list in
//! which a head still moves when its sensor measures, a conversion is read too early, two sensors
//! receive each other's signal (\[000\] §3) or a sensor has no slot. A constant schedule that breaks a
//! rule does not build.
//!
//! In one round a sensor moves, measures and is fused, in this order. The order of the `Fuse` slots is
//! the order of updates, on which the values of the robust grid depend (\[001\] §7). If the robot moves,
//! the round steers after them and sets the motors in a slot of its own, so that the time at which the
//! wheels change their speed does not depend on how long computing it took.
//!
//! Memory: 6 bytes a slot, 22 a sensor; in flash if the schedule is a constant.

mod check;
mod error;
mod round;

pub use error::{MAX_STEPS, ScheduleError};
pub use round::{Activity, Aim, Measuring, ScheduleConfig, Signal, Slot, Station};

/// A checked [`ScheduleConfig`].
///
/// Invariant, for every round:
/// - The slots follow one another without overlap and end within the round, and the round is no
///   longer than a sensor may be without a reading.
/// - Every sensor is moved if it can be, started and read or measured, and fused: each once, in this
///   order, with the time to settle and to convert.
/// - The round steers and drives or does neither: each once, in this order, after all sensors are
///   fused.
/// - No two sensors of one signal ever point within [`ScheduleConfig::apart`] of each other while one
///   receives what the other sends, in any step of their sweeps, late echoes and those of the round
///   before included.
///
/// # Examples
///
/// Two infrared heads that measure at once, and an ultrasonic ranger:
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
/// let [right, left, ranger] = [1, 2, 3].map(SensorId::new);
/// let degrees = |d: i32| BinaryAngle::from_millidegrees(d * 1000);
/// let sweep = Sweep::new(degrees(-90), degrees(90), 37);
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
/// assert_eq!(Schedule::try_new(good)?.period(), 250);
///
/// let mut early = good;
/// early.slots[4].at = 100; // before the head has settled
/// let (slot, activity, ready) = (4, Start(right), 101);
/// let refused = Schedule::try_new(early);
/// assert_eq!(refused, Err(ScheduleError::TooEarly { slot, activity, ready }));
/// # Ok::<(), ScheduleError>(())
/// ```
///
/// A constant that breaks a rule does not build:
///
/// ```compile_fail
/// use certainty_core::schedule::{Activity::Report, Schedule, ScheduleConfig, Slot};
/// use certainty_core::units::BinaryAngle;
///
/// const ROUND: Schedule<1, 0> = Schedule::new(ScheduleConfig {
///     period: 10,
///     stale_after: 2000,
///     apart: BinaryAngle::ZERO,
///     slots: [Slot::new(0, 11, Report)], // 11 ms in a round of 10 ms
///     stations: [],
/// });
/// assert_eq!(ROUND.period(), 10);
/// ```
///
/// With one millisecond less it does:
///
/// ```
/// # use certainty_core::schedule::{Activity::Report, Schedule, ScheduleConfig, Slot};
/// # use certainty_core::units::BinaryAngle;
/// #
/// # const ROUND: Schedule<1, 0> = Schedule::new(ScheduleConfig {
/// #     period: 10,
/// #     stale_after: 2000,
/// #     apart: BinaryAngle::ZERO,
/// slots: [Slot::new(0, 10, Report)],
/// #     stations: [],
/// # });
/// # assert_eq!(ROUND.period(), 10);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Schedule<const SLOTS: usize, const STATIONS: usize>(ScheduleConfig<SLOTS, STATIONS>);

impl<const SLOTS: usize, const STATIONS: usize> Schedule<SLOTS, STATIONS> {
    /// Checks a round, for constants.
    ///
    /// # Panics
    ///
    /// For a round that [`Self::try_new`] refuses: a constant then does not build. Use that at run
    /// time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(config: ScheduleConfig<SLOTS, STATIONS>) -> Self {
        match Self::try_new(config) {
            Ok(schedule) => schedule,
            Err(error) => panic!("{}", error.rule()),
        }
    }

    /// Checks a round.
    ///
    /// Cost: slots times stations, and for two sensors that measure at the same time the number of
    /// rounds after which their sweeps repeat, at most [`MAX_STEPS`].
    ///
    /// # Errors
    ///
    /// [`ScheduleError`] is the first broken rule: of the times of the slots, then their activities,
    /// then each sensor's slots, then steering and driving, then interference.
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

    /// Returns the slots, sorted by their begin.
    #[must_use]
    pub const fn slots(&self) -> &[Slot; SLOTS] {
        &self.0.slots
    }

    /// Returns the sensors, in the order of their numbers.
    #[must_use]
    pub const fn stations(&self) -> &[Station; STATIONS] {
        &self.0.stations
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::SensorId;
    use crate::transducer::Sweep;
    use crate::units::BinaryAngle;

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    const fn sweep(directions: u16) -> Sweep {
        Sweep::new(degrees(-90), degrees(90), directions)
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

    const A: SensorId = SensorId::new(1);
    const B: SensorId = SensorId::new(2);
    const C: SensorId = SensorId::new(3);
    const D: SensorId = SensorId::new(4);

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

    /// Checked at compile time.
    const BUILT: Schedule<15, 4> = Schedule::new(GOOD);

    /// The error of the good round after `change`.
    fn refusal(change: impl FnOnce(&mut ScheduleConfig<15, 4>)) -> ScheduleError {
        let mut config = GOOD;
        change(&mut config);
        Schedule::try_new(config).unwrap_err()
    }

    #[test]
    fn a_good_round_is_accepted() {
        assert_eq!(Schedule::try_new(GOOD), Ok(BUILT));
        assert_eq!(BUILT.slots(), &GOOD.slots);
        assert_eq!(BUILT.stations(), &GOOD.stations);
    }

    #[test]
    fn a_slot_takes_6_bytes_and_a_station_28() {
        assert_eq!(size_of::<Slot>(), 6);
        assert_eq!(size_of::<Station>(), 28);
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
        assert_eq!(
            Schedule::try_new(empty),
            Err(ScheduleError::Size {
                slots: 0,
                stations: 0
            })
        );
    }

    #[test]
    fn a_round_longer_than_stale_after_is_refused() {
        assert_eq!(
            refusal(|c| c.stale_after = 249),
            ScheduleError::RoundTooLong {
                period: 250,
                stale_after: 249
            }
        );
        let equal = ScheduleConfig {
            stale_after: 250,
            ..GOOD
        };
        assert!(Schedule::try_new(equal).is_ok());
    }

    #[test]
    fn more_stations_than_numbers_are_refused() {
        let slots = [Slot::new(0, 1, Activity::Report)];
        let stations = [ranger(0); 256];
        let too_many = ScheduleConfig {
            period: 250,
            stale_after: 2000,
            apart: BinaryAngle::ZERO,
            slots,
            stations,
        };
        assert_eq!(
            Schedule::try_new(too_many),
            Err(ScheduleError::Size {
                slots: 1,
                stations: 256
            })
        );
    }

    #[test]
    fn a_slot_without_time_is_refused() {
        assert_eq!(
            refusal(|c| c.slots[8].lasts = 0),
            ScheduleError::TooShort { slot: 8, needed: 1 }
        );
    }

    #[test]
    fn slots_out_of_order_are_refused() {
        for at in [129, 130] {
            assert_eq!(
                refusal(|c| c.slots[9].at = at),
                ScheduleError::Overrun {
                    slot: 8,
                    end: 140,
                    limit: at
                }
            );
        }
    }

    #[test]
    fn a_slot_that_overruns_the_next_is_refused() {
        assert_eq!(
            refusal(|c| c.slots[8].lasts = 43),
            ScheduleError::Overrun {
                slot: 8,
                end: 173,
                limit: 172
            }
        );
    }

    #[test]
    fn a_slot_that_overruns_the_round_is_refused() {
        assert_eq!(
            refusal(|c| c.period = 249),
            ScheduleError::Overrun {
                slot: 14,
                end: 250,
                limit: 249
            }
        );
        let beyond_16_bits =
            refusal(|c| c.slots[14] = Slot::new(u16::MAX, u16::MAX, Activity::Report));
        assert!(matches!(
            beyond_16_bits,
            ScheduleError::Overrun { end: 131_070, .. }
        ));
    }

    #[test]
    fn a_slot_for_an_unknown_sensor_is_refused() {
        assert_eq!(
            refusal(|c| c.slots[13].activity = Activity::Fuse(SensorId::new(5))),
            ScheduleError::Impossible {
                slot: 13,
                activity: Activity::Fuse(SensorId::new(5))
            }
        );
    }

    #[test]
    fn an_activity_that_a_station_cannot_do_is_refused() {
        for activity in [
            Activity::Move(C),
            Activity::Start(C),
            Activity::Read(C),
            Activity::Measure(A),
        ] {
            assert_eq!(
                refusal(|c| c.slots[13].activity = activity),
                ScheduleError::Impossible { slot: 13, activity }
            );
        }
    }

    #[test]
    fn a_sensor_without_one_of_its_slots_is_refused() {
        for (slot, Slot { activity, .. }) in GOOD.slots.into_iter().enumerate() {
            if activity != Activity::Report {
                assert_eq!(
                    refusal(|c| c.slots[slot].activity = Activity::Report),
                    ScheduleError::NoSlot { activity }
                );
            }
        }
    }

    #[test]
    fn the_same_activity_twice_is_refused() {
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
    fn a_head_has_time_to_settle_after_its_move() {
        assert_eq!(
            refusal(|c| c.slots[6].at = 100),
            ScheduleError::TooEarly {
                slot: 6,
                activity: Activity::Start(A),
                ready: 101
            }
        );
    }

    #[test]
    fn a_conversion_has_70_ms() {
        assert_eq!(
            refusal(|c| c.slots[9].at = 171),
            ScheduleError::TooEarly {
                slot: 9,
                activity: Activity::Read(A),
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
                needed: 30
            }
        );
    }

    #[test]
    fn heads_that_measure_at_once_point_apart_always() {
        // 18 directions of 5° ahead: 90° apart, and 95° when one has returned to the start.
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
        // Both point 90° to the right in the first step.
        assert_eq!(
            refusal(|c| c.stations[1] = head(0, 2)),
            ScheduleError::Interference {
                first: A,
                second: B,
                step: 0
            }
        );
        // A fixed one at 30° is passed in the step before 24 · 5° − 90° = 30°.
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
    fn different_signals_do_not_interfere() {
        let mut config = GOOD;
        config.stations[1] = head(0, 2);
        config.stations[1].signal = Signal::Sound;
        config.slots[1].activity = Activity::Move(B);
        config.stations[2].fades = 0;
        config.stations[3].fades = 0;
        assert!(Schedule::try_new(config).is_ok());
    }

    #[test]
    fn a_late_echo_disturbs_the_next_ranger() {
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
    fn a_late_echo_disturbs_the_next_round() {
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
    fn a_late_echo_disturbs_the_same_ranger() {
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
        assert_eq!(
            alone(71),
            Err(ScheduleError::Interference {
                first: A,
                second: A,
                step: 0
            })
        );
    }

    #[test]
    fn sweeps_that_repeat_too_late_are_refused() {
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

    /// The error of the driving round after `change`.
    fn driving_refusal(change: impl FnOnce(&mut ScheduleConfig<15, 4>)) -> ScheduleError {
        let mut config = DRIVING;
        change(&mut config);
        Schedule::try_new(config).unwrap_err()
    }

    #[test]
    fn a_round_steers_after_all_sensors_are_fused() {
        assert!(Schedule::try_new(DRIVING).is_ok());
        // Slot 12 fuses A; steering before it would ignore the reading of A.
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
    fn steering_and_driving_need_each_other() {
        for (dropped, activity) in [(13, Activity::Steer), (14, Activity::Drive)] {
            assert_eq!(
                driving_refusal(|c| c.slots[dropped].activity = Activity::Report),
                ScheduleError::NoSlot { activity }
            );
        }
    }

    #[test]
    fn steering_or_driving_twice_is_refused() {
        for activity in [Activity::Steer, Activity::Drive] {
            let twice = driving_refusal(|c| c.slots[8].activity = activity);
            assert!(
                matches!(twice, ScheduleError::Twice { activity: found, .. } if found == activity)
            );
        }
    }

    #[test]
    fn errors_say_what_was_wrong_and_what_was_expected() {
        let refused = [
            refusal(|c| c.slots[9].at = 171),
            refusal(|c| c.slots[13].activity = Activity::Move(A)),
            refusal(|c| c.stations[1] = head(0, 2)),
        ];
        assert_eq!(
            refused.map(|error| error.to_string()),
            [
                "a sensor is read before its conversion has ended: slot 9, read sensor 1, expected \
                 at 172 ms or later",
                "an activity has two slots: move sensor 1 in slots 0 and 13",
                "two sensors measure in one direction at the same time: sensors 1 and 2 in round 0; \
                 measure one after the other or shift a sweep",
            ]
        );
    }
}
