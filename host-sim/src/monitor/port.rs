//! The sources of telemetry.

use crate::export::display_path;
use core::fmt;
use core::time::Duration;
use std::ffi::{OsStr, OsString};
use std::fs::{File, Metadata};
use std::io::{self, ErrorKind, IsTerminal, Read};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

/// The longest wait for a TCP connection.
const CONNECTION: Duration = Duration::from_secs(5);

/// The longest wait for a byte of a serial port, before the next try.
const READ_TIMEOUT: Duration = Duration::from_secs(1);

/// A serial port, a file, a pipe, standard input or a TCP address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Port {
    /// Standard input: `-`.
    Stdin,
    /// A host and a port: `tcp:HOST:PORT`.
    Tcp(String),
    /// A path in the file system; its kind is determined when it is opened.
    Path(PathBuf),
}

/// Why a port cannot be opened or read; displays as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// It cannot be opened.
    #[error("{}: cannot be opened ({source}); check its name and permissions", display_path(.path))]
    Open {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// It is a directory.
    #[error("{}: is a directory: expected a serial port, a file or a pipe", display_path(.path))]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// It is a serial port that cannot be set up.
    #[error("{}: is no usable serial port ({source}); check that nothing else has it open, and --baud", display_path(.path))]
    Serial {
        /// The device.
        path: PathBuf,
        /// The error of the operating system.
        source: serialport::Error,
    },
    /// There is no connection to the address, or it is no address.
    #[error("tcp:{}: cannot connect ({source}); check that the sender runs, and write tcp:HOST:PORT", .address.escape_debug())]
    Connect {
        /// The address.
        address: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Reading failed before anything was read.
    #[error("{port}: reading failed ({source}); check the connection and try again")]
    Read {
        /// The port.
        port: String,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// An open port.
struct OpenPort {
    source: Box<dyn Read + Send>,
    is_serial: bool,
}

/// A message from the thread that reads a port.
#[derive(Debug)]
pub enum Arrival {
    /// Bytes.
    Bytes(Vec<u8>),
    /// The end, and the error if it is not the end of the input.
    End(Option<io::Error>),
}

impl From<OsString> for Port {
    fn from(name: OsString) -> Self {
        if name == OsStr::new("-") {
            return Self::Stdin;
        }
        match name.to_str().and_then(|name| name.strip_prefix("tcp:")) {
            Some(address) => Self::Tcp(address.to_owned()),
            None => Self::Path(name.into()),
        }
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stdin => f.write_str("stdin"),
            Self::Tcp(address) => write!(f, "tcp:{}", address.escape_debug()),
            Self::Path(path) => f.write_str(&display_path(path)),
        }
    }
}

impl Port {
    fn open(&self, baud: u32) -> Result<OpenPort, PortError> {
        match self {
            Self::Stdin => Ok(file(io::stdin())),
            Self::Tcp(address) => match connected(address) {
                Ok(stream) => Ok(file(stream)),
                Err(source) => Err(PortError::Connect {
                    address: address.clone(),
                    source,
                }),
            },
            Self::Path(path) => opened(path, baud),
        }
    }

    /// Opens the port, a serial one at `baud`, 8 bits, no parity, one stop bit, and reads it on a thread of its own,
    /// so that a sender that pauses does not block the caller.
    ///
    /// The thread ends with the input, or at the next byte after the receiver is gone. The flag says whether it is
    /// a serial port, whose board may be unplugged and come back.
    ///
    /// # Errors
    ///
    /// [`PortError`] names what cannot be opened, and why.
    pub fn listen(&self, baud: u32) -> Result<(Receiver<Arrival>, bool), PortError> {
        // Enough not to slow a file down, and few enough to bound the memory.
        const WAITING: usize = 16;
        let OpenPort {
            mut source,
            is_serial,
        } = self.open(baud)?;
        let (sender, receiver) = sync_channel(WAITING);
        thread::spawn(move || pump(&mut *source, &sender));
        Ok((receiver, is_serial))
    }
}

/// Passes on the bytes of `source` until it ends or the receiver is gone.
fn pump(source: &mut dyn Read, sender: &SyncSender<Arrival>) {
    let mut buffer = vec![0; 1 << 16];
    loop {
        let arrival = match source.read(&mut buffer) {
            Ok(0) => Arrival::End(None),
            Ok(count) => Arrival::Bytes(buffer[..count].to_vec()),
            Err(error) if is_pause(&error) => continue,
            Err(error) => Arrival::End(Some(error)),
        };
        let last = matches!(arrival, Arrival::End(_));
        if sender.send(arrival).is_err() || last {
            return;
        }
    }
}

/// Whether no bytes came, but more may follow.
fn is_pause(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
    )
}

fn connected(address: &str) -> io::Result<TcpStream> {
    let mut failed = io::Error::new(ErrorKind::NotFound, "no such host");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECTION) {
            Ok(stream) => return Ok(stream),
            Err(error) => failed = error,
        }
    }
    Err(failed)
}

/// A source that ends for good.
fn file(source: impl Read + Send + 'static) -> OpenPort {
    OpenPort {
        source: Box::new(source),
        is_serial: false,
    }
}

fn opened(path: &Path, baud: u32) -> Result<OpenPort, PortError> {
    let failed = |source| PortError::Open {
        path: path.into(),
        source,
    };
    let metadata = path.metadata();
    if metadata.as_ref().is_ok_and(Metadata::is_dir) {
        return Err(PortError::Directory { path: path.into() });
    }
    if !may_be_serial(metadata.as_ref()) {
        return Ok(file(File::open(path).map_err(failed)?));
    }
    let name = path.to_str().ok_or_else(|| {
        failed(io::Error::new(
            ErrorKind::InvalidInput,
            "the name is not text",
        ))
    })?;
    match serialport::new(name, baud).timeout(READ_TIMEOUT).open() {
        Ok(port) => Ok(OpenPort {
            source: Box::new(port),
            is_serial: true,
        }),
        Err(error) => {
            // Other devices, such as /dev/null, are read as files.
            let device = File::open(path).map_err(failed)?;
            if device.is_terminal() {
                let path = path.into();
                return Err(PortError::Serial {
                    path,
                    source: error,
                });
            }
            Ok(file(device))
        }
    }
}

/// Whether to try a path as a serial port: on Unix a character device, and never a pipe, whose
/// writer would see it opened and closed.
#[cfg(unix)]
fn may_be_serial(metadata: Result<&Metadata, &io::Error>) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.is_ok_and(|metadata| metadata.file_type().is_char_device())
}

/// Whether to try a path as a serial port: on other systems one that is no file, such as `COM3`.
#[cfg(not(unix))]
fn may_be_serial(metadata: Result<&Metadata, &io::Error>) -> bool {
    !metadata.is_ok_and(Metadata::is_file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::net::TcpListener;

    /// The next `count` bytes of a port.
    fn all(arrivals: &Receiver<Arrival>, count: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        while bytes.len() < count {
            match arrivals.recv_timeout(Duration::from_secs(10)).unwrap() {
                Arrival::Bytes(more) => bytes.extend(more),
                Arrival::End(why) => panic!("ended after {}: {why:?}", bytes.len()),
            }
        }
        bytes
    }

    #[test]
    fn a_name_is_parsed_to_its_port() {
        let port = |name: &str| Port::from(OsString::from(name));
        assert_eq!(port("-"), Port::Stdin);
        assert_eq!(port("tcp:[::1]:4444"), Port::Tcp("[::1]:4444".into()));
        assert_eq!(port("/dev/ttyACM0"), Port::Path("/dev/ttyACM0".into()));
        assert_eq!(port("./-"), Port::Path("./-".into()));
    }

    #[test]
    fn a_tcp_port_is_read_to_its_end() {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = Port::Tcp(server.local_addr().unwrap().to_string());
        let (arrivals, is_serial) = port.listen(9600).unwrap();
        assert!(!is_serial);
        let (mut sender, _) = server.accept().unwrap();
        sender.write_all(&[1, 0, 2]).unwrap();
        assert_eq!(all(&arrivals, 3), [1, 0, 2]);
        drop(sender);
        assert!(matches!(arrivals.recv(), Ok(Arrival::End(None))));
    }

    #[cfg(unix)]
    #[test]
    fn a_serial_port_is_read_raw_and_after_a_pause() {
        use serialport::{SerialPort, TTYPort};
        let (mut board, host) = TTYPort::pair().unwrap();
        let name = host.name().unwrap();
        drop(host);
        let (arrivals, is_serial) = Port::Path(name.into()).listen(115_200).unwrap();
        assert!(is_serial);
        // All bytes: a line that is not raw would drop or change some.
        let bytes: Vec<u8> = (0..=u8::MAX).collect();
        board.write_all(&bytes).unwrap();
        assert_eq!(all(&arrivals, 256), bytes);
        thread::sleep(READ_TIMEOUT + Duration::from_millis(100));
        board.write_all(b"on").unwrap();
        assert_eq!(all(&arrivals, 2), b"on");
    }
}
