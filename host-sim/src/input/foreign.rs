//! Formats of others: what a file looks like, and how to bring it in.

use core::fmt;

/// A format that is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Foreign {
    /// What the file is.
    is: &'static str,
    /// What to do.
    advice: &'static str,
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "it is {}: {}", self.is, self.advice)
    }
}

/// The columns of a readings file, and of the wide form, in words.
macro_rules! columns {
    ($before:literal) => {
        concat!(
            $before,
            " CSV with the header t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading, or t_s,x_m,y_m,heading_rad,range0_m,range1_m…"
        )
    };
}

/// First bytes of binary files and of text with a signature.
const MAGIC: [(&[u8], &str, &str); 27] = [
    (
        b"\x28\xB5\x2F\xFD",
        "packed by zstd",
        "unpack it with zstd -d FILE",
    ),
    (
        b"7z\xBC\xAF\x27\x1C",
        "a 7z archive",
        "unpack it with 7z x FILE",
    ),
    (
        b"Rar!\x1A\x07",
        "a rar archive",
        "unpack it with unrar x FILE",
    ),
    (
        b"\x04\x22\x4D\x18",
        "packed by lz4",
        "unpack it with lz4 -d FILE",
    ),
    (
        b"\x1F\x9D",
        "packed by compress",
        "unpack it with uncompress FILE",
    ),
    (
        b"#ROSBAG V",
        "a ROS 1 bag",
        columns!("read it with the Python package rosbags and write the scans with their poses as"),
    ),
    (
        b"SQLite format 3\0",
        "a ROS 2 bag or another SQLite database",
        columns!("read it with the Python package rosbags and write the scans with their poses as"),
    ),
    (
        b"\x89MCAP0\r\n",
        "an MCAP recording",
        columns!("read it with the Python package mcap and write the scans with their poses as"),
    ),
    (
        b"\xD4\xC3\xB2\xA1",
        "a network capture (pcap)",
        columns!("decode its packets with the sensor's own software and write"),
    ),
    (
        b"\xA1\xB2\xC3\xD4",
        "a network capture (pcap)",
        columns!("decode its packets with the sensor's own software and write"),
    ),
    (
        b"\x0A\x0D\x0D\x0A",
        "a network capture (pcapng)",
        columns!("decode its packets with the sensor's own software and write"),
    ),
    (
        b"LASF",
        "a LAS point cloud",
        columns!("points have no sensor that saw them; from the scans behind them write"),
    ),
    (
        b"ply\n",
        "a PLY point cloud",
        columns!("points have no sensor that saw them; from the scans behind them write"),
    ),
    (
        b"ply\r\n",
        "a PLY point cloud",
        columns!("points have no sensor that saw them; from the scans behind them write"),
    ),
    (
        b"# .PCD",
        "a PCD point cloud",
        columns!("points have no sensor that saw them; from the scans behind them write"),
    ),
    (
        b"\x89PNG\r\n",
        "a PNG picture",
        "a picture of a map goes into certainty compare, beside a .yaml file; here give a recording",
    ),
    (
        b"\xFF\xD8\xFF",
        "a JPEG picture",
        "a picture of a map goes into certainty compare, beside a .yaml file; here give a recording",
    ),
    (b"GIF8", "a GIF picture", "here give a recording or a table"),
    (
        b"P5\n",
        "a PGM picture",
        "a picture of a map goes into certainty compare, beside a .yaml file; here give a recording",
    ),
    (b"%PDF", "a PDF document", "export its table as CSV"),
    (
        b"\xD0\xCF\x11\xE0",
        "an old Excel or Word document",
        "save the sheet as CSV",
    ),
    (
        b"\x93NUMPY",
        "a NumPy array",
        columns!("save it with numpy.savetxt(…, delimiter=',', header=…) as"),
    ),
    (
        b"\x89HDF",
        "an HDF5 file",
        columns!("read it with h5py or MATLAB and write"),
    ),
    (
        b"MATLAB 5.0 MAT-file",
        "a MATLAB file",
        columns!("write with writetable"),
    ),
    (
        b"PAR1",
        "a Parquet file",
        columns!("read it with pandas and write with to_csv"),
    ),
    (b"\x7FELF", "a program", "here give a recording or a table"),
    (b"{\\rtf", "a document in RTF", "save it as plain text"),
];

impl Foreign {
    /// What a file is by its first bytes; a binary file that is not known too.
    pub(super) fn binary(start: &[u8]) -> Option<Self> {
        let known = MAGIC.iter().find(|(magic, ..)| start.starts_with(magic));
        if let Some(&(_, is, advice)) = known {
            return Some(Self { is, advice });
        }
        if start.get(257..262) == Some(b"ustar") {
            return Some(Self {
                is: "a tar archive",
                advice: "unpack it with tar -xf FILE, and name the file in it",
            });
        }
        None
    }
}

/// A number, as the tables of others have them.
fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}

/// What a file of an unknown format looks like, by its first bytes or its first line.
pub(super) fn foreign(start: &[u8]) -> Option<Foreign> {
    if let Some(binary) = Foreign::binary(start) {
        return Some(binary);
    }
    let text = String::from_utf8_lossy(start);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next()?.trim_start_matches('\u{FEFF}');
    let lower = first.to_ascii_lowercase();
    let words: Vec<&str> = first.split_ascii_whitespace().collect();
    let cells: Vec<&str> = first.split(',').map(str::trim).collect();
    let numbers_behind =
        |from: usize| words.len() > from && words[from..].iter().all(|w| is_number(w));
    let found = |is, advice| Some(Foreign { is, advice });
    if lower.starts_with("<!doctype html") || lower.starts_with("<html") {
        return found(
            "a web page (HTML)",
            "the download went wrong: save the file itself, such as the raw file",
        );
    }
    if first.starts_with('<') {
        return found("XML", columns!("write its readings as"));
    }
    if first.starts_with(['{', '[']) {
        return found("JSON", columns!("write its readings as"));
    }
    if lower.starts_with("%time,field.") {
        return found(
            "a ROS topic written by rostopic echo -p, which has no pose",
            columns!("join the poses of the robot by time and write"),
        );
    }
    if first.starts_with("header:") || first.starts_with("---") {
        return found(
            "a ROS topic as YAML, without poses",
            columns!("join the poses of the robot by time and write"),
        );
    }
    match words.first() {
        Some(&("Odometry" | "Laser")) if numbers_behind(1) => {
            return found(
                "a DP-SLAM log (lines Odometry x y theta and Laser n r1…rn, metres)",
                "write a line FLASER n r1…rn x y theta x y theta time host time for each pair",
            );
        }
        Some(&("O" | "L")) if numbers_behind(1) => {
            return found(
                "a log of Carnegie Mellon's robots (lines O and L, centimetres)",
                "write a line FLASER 180 r1…r180 x y theta x y theta time host time for each L line, in metres",
            );
        }
        Some(word) if word.starts_with("$G") => {
            return found(
                "an NMEA log of a GPS receiver",
                "it has no ranges: give the sensors' own log",
            );
        }
        _ => {}
    }
    if cells.len() > 8 && cells.iter().all(|cell| is_number(cell)) {
        return found(
            "a CSV of numbers without a header, such as Rawseeds' scans (time, n, offset, n ranges)",
            columns!("join the poses of the robot by time and write"),
        );
    }
    if words.len() > 2 && numbers_behind(0) {
        return found(
            "rows of numbers without a header, such as RoboND's measurement.txt (time, n ranges)",
            columns!("join the poses beside them (poses.txt) and write"),
        );
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_format_has_a_line_of_its_own() {
        for (start, word) in [
            (&b"Odometry 1.0 2.0 0.0 \nLaser 3 1 2 3\n"[..], "DP-SLAM"),
            (
                b"O 100.0 200.0 0.0 0.0\nL 100 200 0 1 2\n",
                "Carnegie Mellon",
            ),
            (
                b"1235603336.0, 181, 0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0\n",
                "Rawseeds",
            ),
            (b"%time,field.header.seq,field.ranges0\n", "rostopic"),
            (b"1686487 2000 3285 5110\n", "RoboND"),
            (b"#ROSBAG V2.0\n", "ROS 1 bag"),
            (b"\x89MCAP0\r\n", "MCAP"),
            (b"\xD4\xC3\xB2\xA1\x02\0", "pcap"),
            (b"LASF\0\0", "LAS"),
            (b"ply\nformat ascii 1.0\n", "PLY"),
            (b"# .PCD v0.7\n", "PCD"),
            (b"<!DOCTYPE html>\n", "HTML"),
            (b"{\"ranges\": []}", "JSON"),
            (b"\x89PNG\r\n\x1a\n", "PNG"),
        ] {
            let line = foreign(start).unwrap().to_string();
            assert!(line.contains(word) && line.contains(':'), "{line}");
            assert_eq!(line.lines().count(), 1);
        }
        assert_eq!(foreign(b"Dear all,\nhello\n"), None);
        assert_eq!(foreign(b""), None);
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_panic(bytes: Vec<u8>) {
            let _ = foreign(&bytes);
        }
    }
}
