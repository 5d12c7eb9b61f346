//! Colours that colour-blind people tell apart, and the greys of what is no data.

/// Red, green, blue.
pub(super) type Colour = [u8; 3];

/// What everything is drawn on.
pub(super) const PAPER: Colour = [255, 255, 255];
/// Text.
pub(super) const INK: Colour = [34, 34, 34];
/// Axes and what explains rather than shows.
pub(super) const FRAME: Colour = [110, 110, 110];
/// Lines behind the data.
pub(super) const GRID: Colour = [226, 226, 226];
/// Intervals of x that are set off.
pub(super) const SHADE: Colour = [120, 120, 120];

/// Okabe and Ito's, the strongest first and without their yellow, which white paper swallows.
const SERIES: [Colour; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [0, 0, 0],
];

/// The colour of a series, counted from 0; after seven they begin again.
pub(super) const fn series(index: usize) -> Colour {
    SERIES[index % SERIES.len()]
}
