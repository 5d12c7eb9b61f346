//! Dividing a scan's points into straight pieces (\[003\] §3).

use super::line::Moments;
use certainty_core::units::Millimeters;

/// The points of a scan as a ring: position n is position 0 again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points<'a>(pub &'a [[i16; 2]]);

/// A straight piece: the points from one position to another, both included.
///
/// `first` lies within the list; `last` may lie beyond its end, once around.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
    pub first: u16,
    pub last: u16,
}

/// More pieces than there is room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Full;

pub(super) type Pieces<const ELEMENTS: usize> = heapless::Vec<Piece, ELEMENTS>;

impl<'a> Points<'a> {
    /// How many there are; a scan has at most 2^14.
    pub(super) fn len(self) -> u16 {
        certainty_core::narrow::saturating_u16_of_u64(self.0.len() as u64)
    }

    /// The points of a piece, wherever it starts.
    fn of(self, piece: Piece) -> impl Iterator<Item = &'a [i16; 2]> {
        let first = piece.first.checked_rem(self.len()).unwrap_or(0);
        let from = self.0.get(first.into()..).unwrap_or(&[]);
        let length = piece.last.wrapping_sub(piece.first).wrapping_add(1);
        from.iter().chain(self.0).take(length.into())
    }

    pub(super) fn at(self, position: u16) -> [i16; 2] {
        let position = position.checked_rem(self.len()).unwrap_or(0);
        let point = self.0.get(usize::from(position));
        point.copied().unwrap_or([0, 0])
    }

    pub(super) fn moments(self, piece: Piece) -> Moments {
        Moments::of(self.of(piece))
    }

    /// The position of the point farthest from the line through the piece's ends; the first of several.
    ///
    /// Where the ends are one place there is no line, and the farthest from that place is meant. It is
    /// never one of the ends of a piece of three points or more.
    fn farthest(self, piece: Piece) -> u16 {
        let [from_x, from_y] = self.at(piece.first).map(i64::from);
        let [to_x, to_y] = self.at(piece.last).map(i64::from);
        let (along_x, along_y) = (to_x.wrapping_sub(from_x), to_y.wrapping_sub(from_y));
        let closed = along_x == 0 && along_y == 0;
        let mut best = (piece.first.wrapping_add(1), -1);
        let between = self.of(piece).skip(1);
        let inner = piece.first.wrapping_add(1)..piece.last;
        for (&[x, y], position) in between.zip(inner) {
            let (x, y) = (
                i64::from(x).wrapping_sub(from_x),
                i64::from(y).wrapping_sub(from_y),
            );
            let away = if closed {
                x.wrapping_mul(x).wrapping_add(y.wrapping_mul(y))
            } else {
                let aside = along_x
                    .wrapping_mul(y)
                    .wrapping_sub(along_y.wrapping_mul(x));
                aside.wrapping_abs()
            };
            if away > best.1 {
                best = (position, away);
            }
        }
        best.0
    }

    /// Divides `whole` into pieces whose points deviate by less than `spread` from their line.
    ///
    /// The figure of \[003\] §3, without its recursion: a list is cut at the point farthest from the line
    /// through its ends until what is left of it is straight; the next list starts at that cut.
    /// Differs from \[003\] §3: a list is tested before it is cut, as a last piece that is straight would
    /// otherwise be cut at its noisiest point.
    ///
    /// Cost: n points are looked at twice for each cut; n² / 2 such looks for each piece at the worst,
    /// log₂ n in practice.
    pub(super) fn split<const ELEMENTS: usize>(
        self,
        whole: Piece,
        spread: Millimeters,
        pieces: &mut Pieces<ELEMENTS>,
    ) -> Result<(), Full> {
        let around = self.len();
        let Piece { mut first, last } = whole;
        loop {
            let mut piece = Piece { first, last };
            // Two points are always straight.
            while piece.last > piece.first.wrapping_add(1)
                && !self.moments(piece).spread_below(spread)
            {
                piece.last = self.farthest(piece);
            }
            let next = piece.last;
            if piece.first >= around {
                piece.first = piece.first.wrapping_sub(around);
                piece.last = piece.last.wrapping_sub(around);
            }
            pieces.push(piece).map_err(|_| Full)?;
            if next >= last {
                return Ok(());
            }
            first = next;
        }
    }
}
