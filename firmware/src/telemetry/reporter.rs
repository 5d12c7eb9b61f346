//! The sender: everything that a round reports, into an outbox.

use super::{Encoder, FRAME, Hello, MapReporter, Report, SensorHealth, TooManyCells};
use certainty_core::fusion::{CertaintyGrid, Environment};

/// Where frames go: a queue that a serial port empties.
pub trait Outbox {
    /// Takes the whole of `frame`, at most [`FRAME`] bytes, or nothing of it where there is not
    /// enough room; returns whether it was taken.
    ///
    /// Never waits.
    fn send(&mut self, frame: &[u8]) -> bool;
}

impl<O: Outbox + ?Sized> Outbox for &mut O {
    fn send(&mut self, frame: &[u8]) -> bool {
        (**self).send(frame)
    }
}

/// Encodes reports, hands them to an outbox and counts those that found no room.
#[derive(Debug, Clone)]
struct Sender<O> {
    encoder: Encoder,
    outbox: O,
    unsent: u32,
}

impl<O: Outbox> Sender<O> {
    fn send(&mut self, report: &Report) -> bool {
        let mut frame = [0; FRAME];
        let encoded = self.encoder.encode(report, &mut frame);
        let sent = encoded.is_ok_and(|frame| self.outbox.send(frame));
        if !sent {
            self.unsent = self.unsent.saturating_add(1);
        }
        sent
    }
}

/// Reports the state of a robot with a map of `CELLS` cells.
///
/// ```
/// use certainty_core::fusion::{BayesGrid, Environment, Strength};
/// use certainty_core::health::Health;
/// use certainty_firmware::smart_car::{CELLS, SENSORS, SmartCarShape};
/// use certainty_core::fusion::Shape;
/// use certainty_firmware::telemetry::{Hello, Outbox, Reporter, Statistics, Report};
///
/// /// A queue of 256 bytes.
/// #[derive(Default)]
/// struct Queue(heapless::Vec<u8, 256>);
///
/// impl Outbox for Queue {
///     fn send(&mut self, frame: &[u8]) -> bool {
///         self.0.extend_from_slice(frame).is_ok()
///     }
/// }
///
/// let hello = Hello { geometry: SmartCarShape.geometry(), sensors: SENSORS, rangers: 2, round_ms: 100 };
/// let mut reporter = Reporter::<_, CELLS>::try_new(Queue::default(), hello, 50).ok().unwrap();
/// let grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS])?;
/// let health = [Health::default(); SENSORS as usize];
/// let map = Environment::new(&grid, &health);
///
/// // A round: two parts of the map at most, then the rest.
/// let whole = reporter.send_map(&map, 2);
/// assert!(!whole, "the first map is all cells, in four parts");
/// reporter.send_health(&map);
/// reporter.send(&Report::Statistics(Statistics { unsent: reporter.unsent(), ..Statistics::default() }));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reporter<O, const CELLS: usize> {
    sender: Sender<O>,
    map: MapReporter<CELLS>,
    hello: Hello,
}

impl<O: Outbox, const CELLS: usize> Reporter<O, CELLS> {
    /// Creates a reporter that has sent nothing; one of `keyframe_every` generations of the map is a
    /// keyframe.
    ///
    /// # Errors
    ///
    /// [`TooManyCells`] as [`MapReporter::try_new`], and the outbox back.
    pub fn try_new(
        outbox: O,
        hello: Hello,
        keyframe_every: u16,
    ) -> Result<Self, (TooManyCells, O)> {
        match MapReporter::try_new(hello.geometry, keyframe_every) {
            Ok(map) => Ok(Self {
                sender: Sender {
                    encoder: Encoder::new(),
                    outbox,
                    unsent: 0,
                },
                map,
                hello,
            }),
            Err(error) => Err((error, outbox)),
        }
    }

    /// Sends a report; returns whether the outbox took it.
    pub fn send(&mut self, report: &Report) -> bool {
        self.sender.send(report)
    }

    /// Sends what is next of `map`: before a keyframe the [`Hello`], then at most `parts` parts.
    ///
    /// Returns whether a generation is finished. What found no room is sent at the next call.
    pub fn send_map<G: CertaintyGrid>(&mut self, map: &Environment<'_, G>, parts: u8) -> bool {
        if self.map.begins_keyframe() && !self.sender.send(&Report::Hello(self.hello)) {
            return false;
        }
        let sender = &mut self.sender;
        self.map.report(map, parts, |report| sender.send(report))
    }

    /// Sends the health of every sensor of `map`, a frame each.
    pub fn send_health<G: CertaintyGrid>(&mut self, map: &Environment<'_, G>) {
        for (sensor, health) in map.sensors() {
            self.send(&Report::Health(SensorHealth::new(sensor, health)));
        }
    }

    /// Returns how many frames found no room since the start; saturates.
    #[must_use]
    pub const fn unsent(&self) -> u32 {
        self.sender.unsent
    }

    /// Returns the outbox.
    pub const fn outbox_mut(&mut self) -> &mut O {
        &mut self.sender.outbox
    }

    /// Gives the outbox back.
    pub fn release(self) -> O {
        self.sender.outbox
    }
}
