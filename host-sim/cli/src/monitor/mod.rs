//! `certainty monitor`: a board's telemetry, live.

mod report;
mod words;

use super::{Failure, output};
use certainty_sim::monitor::{Arrival, Port, PortError, Session};
use clap::Args;
use core::num::{NonZeroU32, NonZeroU64};
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use report::Document;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Instant;
use words::{line, screen};

/// How often the screen is drawn anew, and Ctrl-C looked for.
const REFRESH: Duration = Duration::from_millis(100);

/// What the monitor is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A serial port, a file, a pipe, `-` for standard input, or tcp:HOST:PORT
    port: OsString,
    /// The speed of a serial port
    #[arg(long, value_name = "N", default_value = "115200")]
    baud: NonZeroU32,
    /// End after so many reports [default: at the end of the input, or Ctrl-C]
    #[arg(long, value_name = "N")]
    frames: Option<NonZeroU64>,
    /// Print a line for each report, as where there is no terminal, and no live screen
    #[arg(long)]
    plain: bool,
    /// Print one JSON document at the end instead
    #[arg(long, conflicts_with = "plain")]
    json: bool,
}

/// Why listening ended.
#[derive(Debug)]
enum Ended {
    /// The input did.
    Input,
    /// The connection broke.
    Broken(io::Error),
    /// `--frames` reports came.
    Frames,
    /// Ctrl-C, or the system asked.
    Interrupted,
    /// Nobody reads what is printed.
    Unread,
}

impl Ended {
    fn told(&self) -> String {
        match self {
            Self::Input => "end of input".into(),
            Self::Broken(error) => format!("reading failed ({error})"),
            Self::Frames => "enough frames".into(),
            Self::Interrupted => "interrupted".into(),
            Self::Unread => "output closed".into(),
        }
    }
}

/// What is shown while listening.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Show {
    /// Nothing.
    Nothing,
    /// A line for each report.
    Lines,
    /// A screen that is drawn anew.
    Screen,
}

/// Listens to the end and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let port = Port::from(arguments.port.clone());
    let show = if arguments.json {
        Show::Nothing
    } else if arguments.plain || !io::stdout().is_terminal() {
        Show::Lines
    } else {
        Show::Screen
    };
    let mut session = Session::new();
    let ended = listen(arguments, &port, show, &mut session)?;
    session.finish();
    if session.tally().frames == 0 {
        match ended {
            Ended::Input => return Err(Failure::Input(nothing_heard(&port, &session))),
            Ended::Broken(source) => {
                let port = port.to_string();
                return Err(Failure::input(&PortError::Read { port, source }));
            }
            Ended::Frames | Ended::Interrupted | Ended::Unread => {}
        }
    }
    match show {
        Show::Nothing => output::print_json(&Document::new(&port, &session, &ended.told())),
        Show::Lines => output::print(&format!(
            "\n{}{}\n",
            screen(&port, &session, false),
            ended.told()
        )),
        Show::Screen => {
            let screen = screen(&port, &session, output::coloured());
            output::print(&format!("{HOME}{screen}{}\n", ended.told()))
        }
    }
}

/// To the upper left corner, and nothing below it.
const HOME: &str = "\u{1b}[H\u{1b}[J";

fn listen(
    arguments: &Arguments,
    port: &Port,
    show: Show,
    session: &mut Session,
) -> Result<Ended, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed))
        .map_err(|error| Failure::Internal(format!("cannot watch for Ctrl-C: {error}")))?;
    let arrivals = port
        .listen(arguments.baud.get())
        .map_err(|error| Failure::input(&error))?;
    let most = arguments.frames.map_or(u64::MAX, NonZeroU64::get);
    let mut drawn: Option<Instant> = None;
    loop {
        let ended = match arrivals.recv_timeout(REFRESH) {
            Ok(Arrival::Bytes(bytes)) => {
                let lines = take(&bytes, session, most, show == Show::Lines);
                if !lines.is_empty() && !output::offer(&lines)? {
                    return Ok(Ended::Unread);
                }
                (session.tally().frames >= most).then_some(Ended::Frames)
            }
            Ok(Arrival::End(None)) | Err(RecvTimeoutError::Disconnected) => Some(Ended::Input),
            Ok(Arrival::End(Some(error))) => Some(Ended::Broken(error)),
            Err(RecvTimeoutError::Timeout) => None,
        };
        if let Some(ended) = ended {
            return Ok(ended);
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(Ended::Interrupted);
        }
        if show == Show::Screen && drawn.is_none_or(|drawn| drawn.elapsed() >= REFRESH) {
            drawn = Some(Instant::now());
            let screen = screen(port, session, output::coloured());
            if !output::offer(&format!("{HOME}{screen}"))? {
                return Ok(Ended::Unread);
            }
        }
    }
}

/// Takes bytes until `most` reports have come; returns a line for each report and each damage after
/// the first report, if wanted.
///
/// Before it there is only damage: whether the input is telemetry at all is not known yet.
fn take(bytes: &[u8], session: &mut Session, most: u64, wanted: bool) -> String {
    let mut lines = String::new();
    for &byte in bytes {
        if session.tally().frames >= most {
            break;
        }
        if let Some(heard) = session.take(byte)
            && wanted
            && session.tally().frames > 0
        {
            lines += &line(&heard, session);
        }
    }
    lines
}

/// Why an input without a single report is refused.
fn nothing_heard(port: &Port, session: &Session) -> String {
    if let Some(version) = session.other_version() {
        let ours = certainty_firmware::telemetry::VERSION;
        return format!(
            "{port}: telemetry in version {version} of the format, and this program reads {ours}; \
             use the program that came with the firmware"
        );
    }
    match session.bytes() {
        0 => format!("{port}: nothing came; check that it is the board's telemetry"),
        bytes => format!(
            "{port}: not one whole frame in {bytes} bytes; check that it is the board's telemetry, \
             and --baud"
        ),
    }
}
