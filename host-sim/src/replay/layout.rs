//! The columns of a CSV: what a header says of the values below it.
//!
//! Columns are found by their names, in any order and under the names that loggers give them. Units are part of
//! a name (`_mm`, `_m`, `_s`) or come from [`CsvOptions`]; what neither has is assumed and noted, or refused.

use super::recording::{AngleUnit, Format, LengthUnit, RangeUnit, TimeUnit, ZeroMeans};
use crate::input::{Column, Separator, Unit};
use crate::quantity::{Excerpt, FieldOfView};
use certainty_core::units::{BinaryAngle, Millimeters};

/// How to read a CSV.
#[derive(Debug, Clone, Copy)]
pub(super) struct CsvOptions {
    /// Echoes at this distance or farther are no object.
    pub(super) max_range: Option<Millimeters>,
    pub(super) zero: ZeroMeans,
    /// The unit of columns whose names have none.
    pub(super) unit: Option<RangeUnit>,
    pub(super) pose_unit: Option<LengthUnit>,
    pub(super) heading_unit: Option<AngleUnit>,
    pub(super) time_unit: Option<TimeUnit>,
    /// The sensors of the wide form.
    pub(super) fov: Option<FieldOfView>,
    pub(super) start_angle: Option<BinaryAngle>,
}

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Time,
    Sensor,
    X,
    Y,
    Heading,
    Reading,
    /// One of several ranges.
    Range(u32),
}

/// The names of a single column of each role; the first are ours.
const NAMES: [(Role, &[&str]); 6] = [
    (
        Role::Time,
        &[
            "t",
            "time",
            "timestamp",
            "stamp",
            "ts",
            "millis",
            "micros",
            "epoch",
        ],
    ),
    (
        Role::Sensor,
        &[
            "sensor",
            "sensor_id",
            "sensor_no",
            "sensor_nr",
            "sensor_number",
            "sensorid",
            "id",
        ],
    ),
    (
        Role::X,
        &[
            "x",
            "pos_x",
            "x_pos",
            "posx",
            "px",
            "pose_x",
            "position_x",
            "origin_x",
            "robot_x",
        ],
    ),
    (
        Role::Y,
        &[
            "y",
            "pos_y",
            "y_pos",
            "posy",
            "py",
            "pose_y",
            "position_y",
            "origin_y",
            "robot_y",
        ],
    ),
    (
        Role::Heading,
        &[
            "bearing",
            "heading",
            "yaw",
            "theta",
            "th",
            "angle",
            "direction",
            "orientation",
            "azimuth",
            "pose_theta",
            "pos_theta",
            "robot_theta",
        ],
    ),
    (
        Role::Reading,
        &[
            "reading",
            "range",
            "distance",
            "dist",
            "echo",
            "measurement",
            "value",
        ],
    ),
];

/// The names of numbered columns.
const RANGES: [&str; 20] = [
    "range",
    "ranges",
    "ultrasound",
    "ultrasonic",
    "us",
    "sonar",
    "distance",
    "dist",
    "d",
    "r",
    "ir",
    "tof",
    "lidar",
    "laser",
    "beam",
    "echo",
    "reading",
    "sensor",
    "s",
    "u",
];

impl Role {
    fn of(column: &Column) -> Option<Self> {
        match column.number {
            Some(number) => RANGES
                .contains(&column.stem.as_str())
                .then_some(Self::Range(number)),
            None => {
                let named = NAMES
                    .iter()
                    .find(|(_, names)| names.contains(&column.stem.as_str()));
                named.map(|&(role, _)| role)
            }
        }
    }
}

/// The columns of a header line.
struct Header {
    separator: Separator,
    columns: Vec<Column>,
    roles: Vec<Option<Role>>,
}

impl Header {
    fn of(line: &str) -> Self {
        let (separator, columns) = Column::all(line);
        let mut roles: Vec<_> = columns.iter().map(Role::of).collect();
        // A second column of a role is not used.
        for place in 0..roles.len() {
            if roles[..place].contains(&roles[place])
                && !matches!(roles[place], Some(Role::Range(_)))
            {
                roles[place] = None;
            }
        }
        Self {
            separator,
            columns,
            roles,
        }
    }

    fn place(&self, role: Role) -> Option<usize> {
        self.roles.iter().position(|&one| one == Some(role))
    }

    fn has(&self, roles: &[Role]) -> bool {
        roles.iter().all(|&role| self.place(role).is_some())
    }

    fn has_ranges(&self) -> bool {
        self.roles
            .iter()
            .any(|role| matches!(role, Some(Role::Range(_))))
    }

    fn format(&self) -> Option<Format> {
        if !self.has(&[Role::Time, Role::X, Role::Y, Role::Heading]) {
            None
        } else if self.has(&[Role::Sensor, Role::Reading]) {
            Some(Format::Readings)
        } else {
            self.has_ranges().then_some(Format::Wide)
        }
    }
}

/// The format of which `line` is the header.
pub(super) fn header_of(line: &str) -> Option<Format> {
    // No number begins a header, and most lines begin with one.
    let first = line.trim_start().chars().next()?;
    if first.is_ascii_digit() || matches!(first, '-' | '+' | '.') {
        return None;
    }
    Header::of(line).format()
}

/// What a line that is almost a header lacks, in words; `None` if it is no such line.
pub(super) fn lacking(line: &str) -> Option<String> {
    let header = Header::of(line);
    let found = header.roles.iter().flatten().count();
    if found < 3 || header.format().is_some() {
        return None;
    }
    let mut lacks: Vec<&str> = [
        (Role::Time, "time (t_ms)"),
        (Role::X, "x (x_mm)"),
        (Role::Y, "y (y_mm)"),
        (Role::Heading, "direction (bearing_mdeg)"),
    ]
    .into_iter()
    .filter(|&(role, _)| header.place(role).is_none())
    .map(|(_, words)| words)
    .collect();
    if !header.has_ranges() {
        let beam = [
            (Role::Sensor, "sensor number (sensor)"),
            (Role::Reading, "distance (reading)"),
        ];
        let absent = beam
            .into_iter()
            .filter(|&(role, _)| header.place(role).is_none());
        lacks.extend(absent.map(|(_, words)| words));
    }
    Some(lacks.join(", "))
}

/// Millidegrees of a turn.
pub(super) const TURN: f64 = 360_000.0;

const fn length_unit(unit: Unit) -> Option<LengthUnit> {
    Some(match unit {
        Unit::Millimeters => LengthUnit::Millimeters,
        Unit::Centimeters => LengthUnit::Centimeters,
        Unit::Meters => LengthUnit::Meters,
        _ => return None,
    })
}

const fn angle_unit(unit: Unit) -> Option<AngleUnit> {
    Some(match unit {
        Unit::Degrees => AngleUnit::Degrees,
        Unit::Millidegrees => AngleUnit::Millidegrees,
        Unit::Radians => AngleUnit::Radians,
        _ => return None,
    })
}

const fn time_unit(unit: Unit) -> Option<TimeUnit> {
    Some(match unit {
        Unit::Nanoseconds => TimeUnit::Nanoseconds,
        Unit::Microseconds => TimeUnit::Microseconds,
        Unit::Milliseconds => TimeUnit::Milliseconds,
        Unit::Seconds => TimeUnit::Seconds,
        _ => return None,
    })
}

/// Where the values of a line are, and their units.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) columns: usize,
    pub(super) time: usize,
    /// Not known before the first line with numbers if neither the name nor the options have it.
    pub(super) time_unit: Option<TimeUnit>,
    pub(super) time_name: String,
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) x_mm: f64,
    pub(super) y_mm: f64,
    /// Whether metres are assumed.
    pub(super) pose_assumed: bool,
    pub(super) heading: usize,
    pub(super) heading_mdeg: f64,
    /// Whether radians are assumed.
    pub(super) heading_assumed: bool,
    pub(super) beams: Beams,
}

/// Where a line's readings are.
#[derive(Debug, Clone)]
pub(super) enum Beams {
    /// One, in the sensor's and the reading's columns; its millimetres a unit.
    One {
        sensor: usize,
        reading: usize,
        mm: f64,
    },
    /// Several: column, sensor, millimetres a unit, direction in millidegrees from the heading.
    Wide(Vec<WideColumn>),
}

impl Beams {
    /// Whether both are of one form, and sensors of the wide form look where they did.
    pub(super) fn same_sensors(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::One { .. }, Self::One { .. }) => true,
            (Self::Wide(one), Self::Wide(other)) => {
                let look = |column: &WideColumn| (column.sensor, column.aside_mdeg);
                one.iter().map(look).eq(other.iter().map(look))
            }
            _ => false,
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct WideColumn {
    pub(super) place: usize,
    pub(super) sensor: u16,
    pub(super) mm: f64,
    pub(super) aside_mdeg: f64,
}

/// What separates a header's columns, their layout, and notes of what was assumed and left out.
pub(super) type FoundLayout = (Separator, Layout, Vec<String>);

impl Layout {
    /// The layout of `line` if it is a header.
    pub(super) fn of(line: &str, options: &CsvOptions) -> Option<Result<FoundLayout, String>> {
        header_of(line)?;
        Some(Self::of_header(&Header::of(line), options))
    }

    fn of_header(header: &Header, options: &CsvOptions) -> Result<FoundLayout, String> {
        let mut notes = Vec::new();
        let column = |role: Role| {
            let place = header.place(role)?;
            Some((place, &header.columns[place]))
        };
        let needed = |role| column(role).ok_or("a column is missing");
        let (time, time_column) = needed(Role::Time)?;
        let (x, x_column) = needed(Role::X)?;
        let (y, y_column) = needed(Role::Y)?;
        let (heading, heading_column) = needed(Role::Heading)?;
        let time_unit = match time_column.stem.as_str() {
            "millis" => Some(TimeUnit::Milliseconds),
            "micros" => Some(TimeUnit::Microseconds),
            _ => time_column.unit.and_then(time_unit),
        };
        let length = |column: &Column| column.unit.and_then(length_unit);
        let (x_unit, y_unit) = (length(x_column), length(y_column));
        let known = x_unit.or(y_unit).or(options.pose_unit);
        let pose_assumed = known.is_none();
        if pose_assumed {
            notes.push(format!(
                "the columns {} and {} have no unit and are taken as metres: --pose-unit mm, cm or m says it",
                Excerpt::new(&x_column.written),
                Excerpt::new(&y_column.written)
            ));
        }
        let pose = known.unwrap_or(LengthUnit::Meters);
        let angle = heading_column
            .unit
            .and_then(angle_unit)
            .or(options.heading_unit);
        let heading_assumed = angle.is_none();
        if heading_assumed {
            notes.push(format!(
                "the column {} has no unit and is taken as radians: --heading-unit deg or rad says it",
                Excerpt::new(&heading_column.written)
            ));
        }
        let range_mm = |column: &Column, default: Option<RangeUnit>| {
            let unit = column
                .unit
                .and_then(RangeUnit::of)
                .or(options.unit)
                .or(default);
            unit.map(RangeUnit::millimetres).ok_or_else(|| {
                format!(
                    "the column {} has no unit: give --unit mm, cm, m, echo-s or echo-us, or name it {}_m",
                    Excerpt::new(&column.written),
                    Excerpt::new(&column.written)
                )
            })
        };
        let mut used = vec![time, x, y, heading];
        let beams = match (column(Role::Sensor), column(Role::Reading)) {
            (Some((sensor, _)), Some((reading, column))) => {
                used.extend([sensor, reading]);
                let ours = (column.stem == "reading").then_some(RangeUnit::Millimeters);
                let mm = range_mm(column, ours)?;
                Beams::One {
                    sensor,
                    reading,
                    mm,
                }
            }
            _ => {
                let wide = wide_columns(header, options, &range_mm)?;
                used.extend(wide.iter().map(|column| column.place));
                notes.push(mounting(header, &wide));
                Beams::Wide(wide)
            }
        };
        let extra =
            |place: &usize| !used.contains(place) && !header.columns[*place].written.is_empty();
        let extra: Vec<_> = (0..header.columns.len()).filter(extra).collect();
        if !extra.is_empty() {
            let names = extra
                .iter()
                .take(8)
                .map(|&place| Excerpt::new(&header.columns[place].written).to_string());
            let names: Vec<String> = names.collect();
            let more = extra.len() - names.len();
            let more = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            notes.push(format!(
                "columns that are not used: {}{more}",
                names.join(", ")
            ));
        }
        Ok((
            header.separator,
            Self {
                columns: header.columns.len(),
                time,
                time_unit: time_unit.or(options.time_unit),
                time_name: time_column.written.clone(),
                x,
                y,
                x_mm: x_unit.unwrap_or(pose).millimetres(),
                y_mm: y_unit.unwrap_or(pose).millimetres(),
                pose_assumed,
                heading,
                heading_mdeg: angle.unwrap_or(AngleUnit::Radians).millidegrees(),
                heading_assumed,
                beams,
            },
            notes,
        ))
    }
}

/// The ranges of the wide form: those of the name that has the most columns.
fn wide_columns(
    header: &Header,
    options: &CsvOptions,
    range_mm: &impl Fn(&Column, Option<RangeUnit>) -> Result<f64, String>,
) -> Result<Vec<WideColumn>, String> {
    let ranges: Vec<(usize, u32)> = (0..)
        .zip(&header.roles)
        .filter_map(|(place, role)| match role {
            Some(Role::Range(number)) => Some((place, *number)),
            _ => None,
        })
        .collect();
    let stem = |place: usize| header.columns[place].stem.as_str();
    let count = |of: &str| {
        ranges
            .iter()
            .filter(|&&(place, _)| stem(place) == of)
            .count()
    };
    // Of equal counts the first.
    let name = ranges
        .iter()
        .rev()
        .map(|&(place, _)| stem(place))
        .max_by_key(|of| count(of));
    let name = name.unwrap_or_default();
    let mut of_name: Vec<_> = ranges
        .iter()
        .filter(|&&(place, _)| stem(place) == name)
        .collect();
    // A spreadsheet sorts range10 before range2: the number decides the direction, not the place.
    of_name.sort_by_key(|&&(_, number)| number);
    if of_name.len() > 255 {
        return Err(format!(
            "{} range columns: at most 255 sensors are read",
            of_name.len()
        ));
    }
    if options.start_angle.is_none() && options.fov.is_none() {
        return Err(format!(
            "the file does not say where its {} sensors look: expected --start-angle, the direction of the first, \
             counter-clockwise from straight ahead, such as 0deg for sensors evenly around",
            of_name.len()
        ));
    }
    let gaps = match options.fov.map(FieldOfView::degrees) {
        Some(fov) if fov < 360.0 => (fov * 1000.0, of_name.len().saturating_sub(1).max(1)),
        _ => (TURN, of_name.len().max(1)),
    };
    let step = gaps.0 / gaps.1 as f64;
    let default_start = if gaps.0 < TURN { -gaps.0 / 2.0 } else { 0.0 };
    let start = options.start_angle.map_or(default_start, |angle| {
        f64::from(angle.to_bits()) * (TURN / 65536.0)
    });
    let mut columns = Vec::new();
    for (index, &&(place, number)) in of_name.iter().enumerate() {
        let written = &header.columns[place].written;
        let sensor = u16::try_from(number).map_err(|_| {
            format!(
                "the column {}: a sensor has a number from 0 to 65535",
                Excerpt::new(written)
            )
        })?;
        if columns
            .iter()
            .any(|column: &WideColumn| column.sensor == sensor)
        {
            return Err(format!(
                "two columns {}: name each once",
                Excerpt::new(written)
            ));
        }
        columns.push(WideColumn {
            place,
            sensor,
            mm: range_mm(&header.columns[place], None)?,
            aside_mdeg: step.mul_add(index as f64, start),
        });
    }
    Ok(columns)
}

/// The note of where the sensors of the wide form look: the first few and the last.
fn mounting(header: &Header, columns: &[WideColumn]) -> String {
    const FIRST: usize = 4;
    let degrees = |mdeg: f64| (mdeg.rem_euclid(TURN) / 100.0).round() / 10.0;
    let look = |column: &WideColumn| {
        let name = Excerpt::new(&header.columns[column.place].written);
        format!("{name}={}", degrees(column.aside_mdeg))
    };
    let mut looks: Vec<String> = columns.iter().take(FIRST).map(look).collect();
    if columns.len() > FIRST + 1 {
        looks.push("…".into());
    }
    if let Some(last) = columns.get(FIRST..).and_then(<[_]>::last) {
        looks.push(look(last));
    }
    format!(
        "the {} sensors are taken to look to {} degrees, counter-clockwise from straight ahead: --start-angle and \
         --fov say it",
        columns.len(),
        looks.join(", ")
    )
}
