//! What the tests of this folder share: a sender, a receiver, and reports of every kind.

use super::*;
use crate::smart_car::{CELLS, SmartCarShape};
use certainty_control::{Effort, SpeedLimit, Wheels};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Cell, CertaintyGrid, Environment, Geometry, Measurement, Shape};
use certainty_core::health::{Confidence, Health, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use proptest::prelude::*;

/// A grid whose cells a test sets.
pub(super) struct Drawn {
    geometry: Geometry,
    cells: Vec<u8>,
}

impl Drawn {
    pub(super) fn smart_car(cells: &[u8; CELLS]) -> Self {
        Self {
            geometry: SmartCarShape.geometry(),
            cells: cells.to_vec(),
        }
    }
}

impl CertaintyGrid for Drawn {
    fn clear(&mut self) {
        self.cells.fill(Certainty::UNCERTAIN.to_bits());
    }

    fn geometry(&self) -> Geometry {
        self.geometry
    }

    fn add(&mut self, cell: Cell, measurement: Measurement, _sensors: &mut [Health]) {
        self.cells[cell.index()] = measurement.certainty.to_bits();
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        Certainty::from_bits(self.cells[cell.index()])
    }

    fn memory_bytes(&self) -> usize {
        self.cells.len()
    }
}

/// An outbox that stores all bytes, with room for a limited number of frames.
#[derive(Debug, Clone, Default)]
pub(super) struct Line {
    pub(super) bytes: Vec<u8>,
    pub(super) room: Option<usize>,
}

impl Outbox for Line {
    fn send(&mut self, frame: &[u8]) -> bool {
        match &mut self.room {
            Some(0) => return false,
            Some(room) => *room -= 1,
            None => {}
        }
        self.bytes.extend_from_slice(frame);
        true
    }
}

pub(super) const HELLO: Hello = Hello {
    geometry: Geometry::new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0)),
    sensors: 3,
    rangers: 2,
    round_ms: 100,
};

pub(super) fn reporter(keyframe_every: u16) -> Reporter<Line, CELLS> {
    Reporter::try_new(Line::default(), HELLO, keyframe_every).unwrap()
}

/// A receiver that stores its reports and every map that was complete.
pub(super) struct Receiver {
    pub(super) decoder: Decoder,
    pub(super) view: MapView<[u8; CELLS]>,
    pub(super) reports: Vec<Report>,
    pub(super) complete: Vec<Vec<u8>>,
}

impl Receiver {
    pub(super) fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            view: MapView::new([7; CELLS], [7; CELLS]),
            reports: Vec::new(),
            complete: Vec::new(),
        }
    }

    pub(super) fn receive(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let Some(decoded) = self.decoder.push(byte) else {
                continue;
            };
            if let Ok(frame) = decoded {
                self.view.take(&frame.report);
                self.reports.push(frame.report);
            }
            if let MapState::Complete { .. } = self.view.state() {
                self.complete.push(self.cells());
            }
        }
        self.decoder.finish();
    }

    pub(super) fn cells(&self) -> Vec<u8> {
        self.view.cells().map(Certainty::to_bits).collect()
    }
}

/// Returns a receiver that has received `bytes`.
pub(super) fn received(bytes: &[u8]) -> Receiver {
    let mut receiver = Receiver::new();
    receiver.receive(bytes);
    receiver
}

/// The output of some rounds: the bytes on the line, the reports and the maps.
pub(super) struct Sent {
    pub(super) bytes: Vec<u8>,
    pub(super) reports: Vec<Report>,
    pub(super) maps: Vec<Vec<u8>>,
}

/// Sends rounds of a robot whose map changes at random: maps, health and statistics.
pub(super) fn rounds(count: u32, seed: u32, keyframe_every: u16) -> Sent {
    let mut reporter = reporter(keyframe_every);
    let mut cells = [128_u8; CELLS];
    let mut dice = seed | 1;
    let mut maps = Vec::new();
    for round in 0..count {
        for _ in 0..9 {
            dice ^= dice << 13;
            dice ^= dice >> 17;
            dice ^= dice << 5;
            cells[dice as usize % CELLS] = (dice >> 16) as u8;
        }
        let grid = Drawn::smart_car(&cells);
        let health = [Health::default(); 3];
        let map = Environment::new(&grid, &health);
        // The grid is constant during a generation, so that its map is known.
        while !reporter.send_map(&map, 2) {}
        maps.push(cells.to_vec());
        reporter.send_health(&map);
        reporter.send(&Report::Statistics(Statistics {
            round,
            ..Statistics::default()
        }));
    }
    let bytes = reporter.release().bytes;
    let reports = received(&bytes).reports;
    Sent {
        bytes,
        reports,
        maps,
    }
}

fn readings() -> impl Strategy<Value = Reading> {
    prop_oneof![
        any::<u32>().prop_map(|mm| Reading::Echo(Millimeters::new(mm))),
        Just(Reading::NoObject),
        Just(Reading::TooNear),
        Just(Reading::Missing(Missing::Timeout)),
        Just(Reading::Missing(Missing::Bus)),
        Just(Reading::Missing(Missing::Implausible)),
        Just(Reading::Missing(Missing::Late)),
    ]
}

fn findings() -> impl Strategy<Value = Finding> {
    prop::sample::select(&Finding::ALL[..])
}

fn sensors() -> impl Strategy<Value = SensorId> {
    (1..=u8::MAX).prop_map(|number| SensorId::try_new(number).unwrap())
}

fn geometries() -> impl Strategy<Value = Geometry> {
    let sizes = (1..=u16::MAX, 1..=u16::MAX, 1..=4096_u32);
    let corners = (-(1 << 28)..=0, -(1 << 28)..=0);
    (sizes, corners).prop_map(|((columns, rows, cell), (x, y))| {
        let cell = Millimeters::new(cell);
        Geometry::try_new(columns, rows, cell, Point::from_mm(x, y)).unwrap()
    })
}

fn map_parts() -> impl Strategy<Value = MapPart> {
    let end = prop::option::of(
        (any::<u16>(), any::<u32>()).prop_map(|(cells, digest)| MapEnd { cells, digest }),
    );
    let cells = prop::collection::vec(any::<u8>(), 0..=PART_CELLS);
    (any::<u16>(), any::<u16>(), cells, end).prop_map(|(generation, start, cells, end)| MapPart {
        generation,
        start,
        cells: cells.into_iter().collect(),
        end,
    })
}

fn drives() -> impl Strategy<Value = Drive> {
    let states = prop::sample::select(vec![
        DriveState::Looking,
        DriveState::from(SpeedLimit::None),
        DriveState::from(SpeedLimit::Arrived),
        DriveState::from(SpeedLimit::Slowed),
        DriveState::from(SpeedLimit::Blind),
        DriveState::from(SpeedLimit::NoWay),
        DriveState::Late,
        DriveState::Refused,
        DriveState::Lost,
        DriveState::Restarted,
    ]);
    let numbers = any::<(i32, i32, u16, i32, i32, u32)>();
    (states, numbers).prop_map(|(state, (x, y, heading, right, left, to_goal))| Drive {
        pose: Pose::new(Point::from_mm(x, y), BinaryAngle::from_bits(heading)),
        wheels: Wheels {
            right: Effort::from_bits(right),
            left: Effort::from_bits(left),
        },
        state,
        to_goal: Millimeters::new(to_goal),
    })
}

pub(super) fn reports() -> impl Strategy<Value = Report> {
    let status = prop::sample::select(vec![
        Status::Healthy,
        Status::Suspect,
        Status::Failed,
        Status::Recovering,
    ]);
    let counts = any::<[u32; 4]>();
    prop_oneof![
        (geometries(), any::<(u8, u8, u32)>()).prop_map(
            |(geometry, (sensors, rangers, round_ms))| {
                Report::Hello(Hello {
                    geometry,
                    sensors,
                    rangers,
                    round_ms,
                })
            }
        ),
        map_parts().prop_map(Report::Map),
        any::<(i32, i32, u16)>().prop_map(|(x, y, heading)| {
            let heading = BinaryAngle::from_bits(heading);
            Report::Pose(Pose::new(Point::from_mm(x, y), heading))
        }),
        (sensors(), any::<u16>(), readings(), findings()).prop_map(
            |(sensor, direction, reading, finding)| {
                Report::Head(Head {
                    sensor,
                    direction: BinaryAngle::from_bits(direction),
                    reading,
                    finding,
                })
            }
        ),
        (sensors(), status, any::<u16>(), counts).prop_map(
            |(sensor, status, confidence, [readings, missing, confirmations, contradictions])| {
                Report::Health(SensorHealth {
                    sensor,
                    status,
                    confidence: Confidence::from_bits(confidence),
                    readings,
                    missing,
                    confirmations,
                    contradictions,
                })
            }
        ),
        (any::<u8>(), readings())
            .prop_map(|(number, reading)| Report::Ranger(Ranger { number, reading })),
        drives().prop_map(Report::Drive),
        counts.prop_map(|[round, tick, overruns, unsent]| {
            Report::Statistics(Statistics {
                round,
                tick: Ticks::new(tick),
                overruns,
                unsent,
            })
        }),
    ]
}
