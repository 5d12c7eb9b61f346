//! What is sent of a map, and when it is shown as whole.

use super::*;

const NO_HEALTH: [Health; 0] = [];

/// What `reporter` sends of a map with these cells in one call, and whether the generation ended.
fn sent(
    reporter: &mut Reporter<Line, CELLS>,
    cells: &[u8; CELLS],
    parts: u8,
) -> (Vec<Report>, bool) {
    let grid = Drawn::smart_car(cells);
    let done = reporter.send_map(&Environment::new(&grid, &NO_HEALTH), parts);
    let bytes = core::mem::take(&mut reporter.outbox_mut().bytes);
    (heard(&bytes).reports, done)
}

/// The runs among `reports`: first cell and number of cells.
fn runs(reports: &[Report]) -> Vec<(u16, usize)> {
    let parts = reports.iter().filter_map(|report| match report {
        Report::Map(part) => Some((part.start, part.cells.len())),
        _ => None,
    });
    parts.collect()
}

#[test]
fn the_first_generation_is_a_hello_and_all_cells() {
    let cells = core::array::from_fn(|index| index as u8);
    let (reports, done) = sent(&mut reporter(50), &cells, 4);
    assert!(done);
    assert_eq!(reports[0], Report::Hello(HELLO));
    assert_eq!(runs(&reports), [(0, 48), (48, 48), (96, 48), (144, 43)]);
    let ends: Vec<bool> = reports[1..]
        .iter()
        .map(|report| matches!(report, Report::Map(MapPart { end: Some(_), .. })))
        .collect();
    assert_eq!(ends, [false, false, false, true]);
}

#[test]
fn afterwards_only_what_changed_is_sent_a_run_at_a_time() {
    let mut reporter = reporter(50);
    let mut cells = [128; CELLS];
    sent(&mut reporter, &cells, 4);
    assert_eq!(
        runs(&sent(&mut reporter, &cells, 4).0),
        [(0, 0)],
        "only the digest"
    );
    cells[60] = 1;
    assert_eq!(runs(&sent(&mut reporter, &cells, 4).0), [(60, 1)]);
    cells[0] = 2;
    cells[40] = 2;
    cells[186] = 2;
    assert_eq!(runs(&sent(&mut reporter, &cells, 4).0), [(0, 41), (186, 1)]);
}

#[test]
fn a_call_sends_no_more_parts_than_it_may_and_the_next_goes_on() {
    let mut reporter = reporter(50);
    let cells = [9; CELLS];
    let (reports, done) = sent(&mut reporter, &cells, 3);
    assert_eq!((runs(&reports).len(), done), (3, false));
    let (reports, done) = sent(&mut reporter, &cells, 3);
    assert_eq!((runs(&reports), done), (vec![(144, 43)], true));
    assert!(sent(&mut reporter, &cells, 0).0.is_empty());
}

#[test]
fn one_generation_of_so_many_is_a_keyframe() {
    for (every, expected) in [(0, "kkkkkk"), (1, "kkkkkk"), (3, "k--k--k"), (5, "k----k")] {
        let mut reporter = reporter(every);
        let kinds: String = (0..expected.len())
            .map(|_| {
                let (reports, done) = sent(&mut reporter, &[128; CELLS], 4);
                assert!(done);
                if reports[0] == Report::Hello(HELLO) {
                    assert_eq!(runs(&reports).len(), 4);
                    'k'
                } else {
                    '-'
                }
            })
            .collect();
        assert_eq!(kinds, expected, "every {every}");
    }
}

#[test]
fn what_found_no_room_is_sent_again_and_counted() {
    let mut reporter = reporter(50);
    let cells = [5; CELLS];
    let mut receiver = Receiver::new();
    let mut unsent = 0;
    for room in [0, 1, 0, 2, 1, 0, 3, 9] {
        reporter.outbox_mut().room = Some(room);
        let grid = Drawn::smart_car(&cells);
        let done = reporter.send_map(&Environment::new(&grid, &NO_HEALTH), 9);
        unsent += u32::from(!done);
        assert_eq!(reporter.unsent(), unsent);
        let bytes = core::mem::take(&mut reporter.outbox_mut().bytes);
        receiver.hear(&bytes);
    }
    assert!(matches!(receiver.view.state(), MapState::Complete { .. }));
    assert_eq!(receiver.cells(), cells);
    assert!(unsent > 0 && receiver.decoder.tally().lost > 0);
}

#[test]
fn a_map_of_another_size_than_announced_is_refused() {
    assert!(MapReporter::<186>::try_new(SmartCarShape.geometry(), 1).is_err());
    assert!(MapReporter::<187>::try_new(SmartCarShape.geometry(), 1).is_ok());
    let (_, line) = Reporter::<_, 3>::try_new(Line::default(), HELLO, 1).unwrap_err();
    assert!(line.bytes.is_empty(), "the outbox comes back");
}

#[test]
fn a_map_is_complete_only_when_its_digest_agrees() {
    let sent = rounds(6, 1, 3);
    let mut receiver = Receiver::new();
    let mut states = Vec::new();
    for frame in sent.bytes.split_inclusive(|&byte| byte == 0) {
        receiver.hear(frame);
        states.push(receiver.view.state());
    }
    // A hello and three parts of the first map, then its last.
    assert_eq!(states[..4], [MapState::Incomplete; 4]);
    assert_eq!(states[4], MapState::Complete { generation: 0 });
    assert_eq!(states.last(), Some(&MapState::Complete { generation: 5 }));
    assert_eq!(receiver.cells(), sent.maps[5]);
}

/// Every frame lost once: a map with a hole is never shown as whole, and the next keyframe heals it.
#[test]
fn whichever_frame_is_lost_no_wrong_map_is_shown_as_right() {
    let sent = rounds(7, 3, 3);
    let frames: Vec<&[u8]> = sent.bytes.split_inclusive(|&byte| byte == 0).collect();
    let mut damaged = 0;
    for lost in 0..frames.len() {
        let rest: Vec<u8> = (0..frames.len())
            .filter(|&index| index != lost)
            .flat_map(|index| frames[index].to_vec())
            .collect();
        let receiver = heard(&rest);
        for map in &receiver.complete {
            assert!(sent.maps.contains(map), "frame {lost}");
        }
        let maps = |receiver: &Receiver| receiver.complete.len();
        damaged += usize::from(maps(&receiver) + 1 < maps(&heard(&sent.bytes)));
        // The last generation is a keyframe: nothing before it matters.
        if lost + 9 < frames.len() {
            assert_eq!(receiver.view.state(), MapState::Complete { generation: 6 });
        }
    }
    assert!(damaged > 10, "the loss of a part shows");
}

#[test]
fn a_map_whose_last_parts_are_all_lost_does_not_stay_complete() {
    let sent = rounds(4, 5, 50);
    let mut receiver = Receiver::new();
    let mut ends = 0;
    for frame in sent.bytes.split_inclusive(|&byte| byte == 0) {
        let report = heard(frame).reports.pop();
        if matches!(report, Some(Report::Map(MapPart { end: Some(_), .. }))) {
            ends += 1;
            if ends > 1 {
                continue;
            }
        }
        receiver.hear(frame);
    }
    assert_eq!(receiver.view.state(), MapState::Incomplete);
}

#[test]
fn the_same_cells_in_another_grid_are_another_map() {
    let cells = [77; CELLS];
    let (reports, _) = sent(&mut reporter(1), &cells, 9);
    for (columns, rows, cell, x) in [(11, 17, 100, -850), (17, 11, 50, -850), (17, 11, 100, 0)] {
        let cell = Millimeters::new(cell);
        let geometry = Geometry::try_new(columns, rows, cell, Point::from_mm(x, 0)).unwrap();
        let mut view = MapView::new([0; CELLS], [0; CELLS]);
        view.take(&Report::Hello(Hello { geometry, ..HELLO }));
        reports[1..].iter().for_each(|report| view.take(report));
        assert_eq!(view.state(), MapState::Incomplete);
    }
}

#[test]
fn a_map_too_large_to_keep_is_said_so() {
    let mut view = MapView::new([0; CELLS - 1], [0; CELLS - 1]);
    let (reports, _) = sent(&mut reporter(1), &[77; CELLS], 9);
    reports.iter().for_each(|report| view.take(report));
    assert_eq!(view.state(), MapState::TooLarge);
    assert_eq!(view.cells().count(), 0);
}

#[test]
fn parts_without_a_hello_are_no_map() {
    let (reports, _) = sent(&mut reporter(1), &[77; CELLS], 9);
    let mut view = MapView::new([0; CELLS], [0; CELLS]);
    reports[1..].iter().for_each(|report| view.take(report));
    assert_eq!((view.state(), view.cells().count()), (MapState::Unknown, 0));
}

proptest! {
    /// Whatever the cells do while parts go out, a generation is of at most four parts, and the map
    /// agrees once it stands still.
    #[test]
    fn a_map_that_changes_while_it_is_sent_agrees_in_the_end(
        changes in prop::collection::vec((0..CELLS, any::<u8>(), 0..3_u8, 0..4_usize), 0..60),
        keyframe_every in 0..6_u16,
    ) {
        let mut reporter = reporter(keyframe_every);
        let mut cells = [128; CELLS];
        let mut receiver = Receiver::new();
        let mut parts = 0;
        for (place, value, calls, room) in changes {
            cells[place] = value;
            reporter.outbox_mut().room = Some(room);
            let grid = Drawn::smart_car(&cells);
            let done = reporter.send_map(&Environment::new(&grid, &NO_HEALTH), calls);
            let bytes = core::mem::take(&mut reporter.outbox_mut().bytes);
            parts += runs(&heard(&bytes).reports).len();
            receiver.hear(&bytes);
            prop_assert!(parts <= 4, "a generation of {parts} parts");
            if done {
                parts = 0;
                let complete = matches!(receiver.view.state(), MapState::Complete { .. });
                prop_assert!(complete);
            }
        }
        reporter.outbox_mut().room = None;
        let grid = Drawn::smart_car(&cells);
        for _ in 0..2 {
            while !reporter.send_map(&Environment::new(&grid, &NO_HEALTH), 1) {}
        }
        receiver.hear(&reporter.release().bytes);
        prop_assert_eq!(receiver.cells(), cells);
    }
}
