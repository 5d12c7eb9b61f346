//! Claims about the world and what a ray meets in it.

use super::*;
use proptest::prelude::*;

const fn mm(mm: u32) -> Millimeters {
    Millimeters::new(mm)
}

const fn degrees(degrees: i32) -> BinaryAngle {
    BinaryAngle::from_millidegrees(degrees * 1000)
}

const FAR: Millimeters = mm(10_000);

fn only(obstacle: Obstacle) -> World {
    World::new("one", vec![obstacle])
}

fn near(actual: Option<f64>, expected: f64) -> bool {
    actual.is_some_and(|mm| (mm - expected).abs() < 1e-3)
}

#[test]
fn an_upright_box_is_met_at_its_near_side() {
    let world =
        only(Obstacle::rectangle(Point::from_mm(0, 500), (mm(200), mm(100)), degrees(0)).unwrap());
    assert_eq!(
        world.distance(Point::ORIGIN, degrees(90), FAR),
        Some(450.0 - 0.5)
    );
    assert_eq!(world.distance(Point::ORIGIN, degrees(-90), FAR), None);
    assert_eq!(world.distance(Point::ORIGIN, degrees(0), FAR), None);
    // From the side, along a line through it.
    assert_eq!(
        world.distance(Point::from_mm(-1000, 500), degrees(0), FAR),
        Some(900.0 - 0.5)
    );
    // A hair beside it: the ray runs along x = 100.5.
    assert_eq!(
        world.distance(Point::from_mm(100, 0), degrees(90), FAR),
        None
    );
    assert_eq!(
        world.distance(Point::from_mm(99, 0), degrees(90), FAR),
        Some(449.5)
    );
}

#[test]
fn a_turned_box_is_met_at_its_corner() {
    // A square of side 200 on its corner reaches 100·√2 towards the ray.
    let world =
        only(Obstacle::rectangle(Point::from_mm(0, 500), (mm(200), mm(200)), degrees(45)).unwrap());
    let from = Point::from_mm(0, 0);
    let met = world.distance(from, degrees(90), FAR);
    // The ray runs half a millimetre beside the corner, where the side is half a millimetre up.
    assert!(near(met, 500.0 - 100.0 * 2.0_f64.sqrt()), "{met:?}");
}

#[test]
fn a_disc_is_met_on_its_circle() {
    let world = only(Obstacle::disc(Point::from_mm(300, 400), mm(50)).unwrap());
    let towards = BinaryAngle::from_millidegrees(53_130); // 3-4-5
    let met = world.distance(Point::ORIGIN, towards, FAR).unwrap();
    let expected = (299.5_f64.powi(2) + 399.5_f64.powi(2)).sqrt() - 50.0;
    assert!((met - expected).abs() < 0.01, "{met} vs {expected}");
    assert_eq!(
        world.distance(Point::ORIGIN, towards.wrapping_add(BinaryAngle::HALF), FAR),
        None
    );
}

#[test]
fn a_wall_has_the_thickness_it_was_given() {
    let world =
        only(Obstacle::wall(Point::from_mm(-500, 600), Point::from_mm(500, 600), mm(20)).unwrap());
    assert_eq!(world.distance(Point::ORIGIN, degrees(90), FAR), Some(589.5));
    assert!(world.occupied(Point::from_mm(0, 590)) && world.occupied(Point::from_mm(0, 609)));
    assert!(!world.occupied(Point::from_mm(0, 589)) && !world.occupied(Point::from_mm(0, 610)));
    assert!(!world.occupied(Point::from_mm(500, 600)) && world.occupied(Point::from_mm(499, 600)));
}

#[test]
fn a_box_covers_exactly_the_millimetres_between_its_coordinates() {
    let world = only(
        Obstacle::rectangle(Point::from_mm(300, 500), (mm(200), mm(100)), degrees(0)).unwrap(),
    );
    let covered = (0..1000)
        .filter(|&x| world.occupied(Point::from_mm(x, 500)))
        .collect::<Vec<_>>();
    assert_eq!(covered, (200..400).collect::<Vec<_>>());
}

#[test]
fn a_ray_that_starts_inside_has_gone_no_way() {
    let rectangle = Obstacle::rectangle(Point::ORIGIN, (mm(100), mm(50)), degrees(30)).unwrap();
    let disc = Obstacle::disc(Point::ORIGIN, mm(40)).unwrap();
    for obstacle in [rectangle, disc] {
        for bearing in (0..360).step_by(7) {
            let met = only(obstacle).distance(Point::ORIGIN, degrees(bearing), FAR);
            assert_eq!(met, Some(0.0), "{obstacle:?} at {bearing}");
        }
    }
}

#[test]
fn what_is_beyond_the_range_is_not_met() {
    let world = only(Obstacle::disc(Point::from_mm(0, 1000), mm(100)).unwrap());
    assert!(
        world
            .distance(Point::ORIGIN, degrees(90), mm(899))
            .is_none()
    );
    assert!(
        world
            .distance(Point::ORIGIN, degrees(90), mm(900))
            .is_some()
    );
}

#[test]
fn the_nearest_of_several_is_met_first() {
    let far = Obstacle::disc(Point::from_mm(0, 1000), mm(100)).unwrap();
    let close = Obstacle::disc(Point::from_mm(0, 500), mm(100)).unwrap();
    for order in [vec![far, close], vec![close, far]] {
        let met = World::new("two", order).distance(Point::ORIGIN, degrees(90), FAR);
        assert!(met.unwrap() < 401.0);
    }
}

#[test]
fn bounds_enclose_everything() {
    let world = World::new(
        "two",
        vec![
            Obstacle::rectangle(Point::from_mm(0, 0), (mm(200), mm(200)), degrees(45)).unwrap(),
            Obstacle::disc(Point::from_mm(1000, -50), mm(10)).unwrap(),
        ],
    );
    assert_eq!(
        world.bounds(),
        Some(Bounds {
            lower_left: Point::from_mm(-142, -142),
            upper_right: Point::from_mm(1010, 142),
        })
    );
    assert_eq!(World::new("open", vec![]).bounds(), None);
}

#[test]
fn half_the_beams_of_the_built_in_scene_see_something_at_varied_distances() {
    let world = World::built_in();
    let beams: Vec<_> = (0..=180)
        .map(|bearing| world.distance(Point::ORIGIN, degrees(bearing), mm(800)))
        .collect();
    let echoes: Vec<f64> = beams.iter().copied().flatten().collect();
    let share = echoes.len() as f64 / beams.len() as f64;
    assert!((0.4..=0.6).contains(&share), "{share} of the beams echo");
    let (least, most) = echoes
        .iter()
        .fold((f64::MAX, 0.0_f64), |(l, m), &d| (l.min(d), m.max(d)));
    assert!(least > 150.0 && least < 400.0, "nearest {least}");
    assert!(most > 550.0 && most < 800.0, "farthest {most}");
    // Left, ahead and right all have something to see and somewhere to go.
    for third in beams.chunks(61) {
        let echoes = third.iter().flatten().count();
        assert!((10..=50).contains(&echoes), "{echoes} of {}", third.len());
    }
}

#[test]
fn the_built_in_scene_keeps_clear_of_the_sensors_and_stays_on_the_grid() {
    let world = World::built_in();
    for obstacle in world.obstacles() {
        assert!(obstacle.clearance(Point::ORIGIN) > 150.0, "{obstacle:?}");
    }
    let Bounds {
        lower_left: low,
        upper_right: high,
    } = world.bounds().unwrap();
    assert!(low.x_mm() >= -850 && low.y_mm() >= 0, "{low:?}");
    assert!(high.x_mm() <= 850 && high.y_mm() <= 1100, "{high:?}");
}

#[test]
fn random_worlds_keep_clear_of_every_sensor() {
    let layout = Layout {
        sensors: vec![Point::from_mm(-100, 0), Point::from_mm(100, 20)],
        ..Layout::default()
    };
    for seed in 0..200 {
        let world = World::random(&layout, seed).unwrap();
        assert_eq!(world.obstacles().len(), 7);
        for obstacle in world.obstacles() {
            for &sensor in &layout.sensors {
                assert!(obstacle.clearance(sensor) >= 150.0, "seed {seed}");
            }
        }
    }
}

#[test]
fn layouts_that_cannot_be_are_refused() {
    let ok = Layout::default;
    let full = Layout {
        keep_clear: mm(5000),
        ..ok()
    };
    assert_eq!(World::random(&full, 1), Err(LayoutError::NoRoom));
    let none = Layout {
        boxes: 0,
        discs: 0,
        ..ok()
    };
    assert_eq!(World::random(&none, 1), Err(LayoutError::NoObstacle));
    let inverted = Layout {
        smallest: mm(301),
        ..ok()
    };
    assert_eq!(World::random(&inverted, 1), Err(LayoutError::Size));
    let turned = Layout {
        area: Bounds {
            lower_left: Point::from_mm(1, 0),
            upper_right: Point::ORIGIN,
        },
        ..ok()
    };
    assert_eq!(World::random(&turned, 1), Err(LayoutError::EmptyArea));
}

fn complaint(text: &str) -> String {
    World::parse(text.as_bytes(), "w.toml")
        .unwrap_err()
        .to_string()
}

#[test]
fn what_is_wrong_with_a_file_is_said_with_its_line() {
    let length = "write a length such as 100mm, 35cm or 8m";
    for (text, line) in [
        ("[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = \"0mm\"", "w.toml:3: an obstacle needs a size above 0mm".to_owned()),
        ("\n[[box]]\ncenter = [\"0mm\", \"1m\"]\nsize = [\"1m\", \"-1m\"]", format!("w.toml:4: '-1m' is negative: {length}")),
        ("[[wall]]\nfrom = [\"1m\", \"1m\"]\nto = [\"1m\", \"1m\"]", "w.toml:1: a wall must end elsewhere than it starts".to_owned()),
        ("[[disc]]\nradius = \"1m\"\ncenter = [\"0mm\", \"300000m\"]", "w.toml:3: '300000m' is too large: at most 268435456mm".to_owned()),
        ("name = \"void\"\n", "w.toml:2: the world has no obstacle: add for example: [[disc]] center = [\"0mm\", \"500mm\"] radius = \"80mm\", on three lines".to_owned()),
    ] {
        assert_eq!(complaint(text), line);
    }
    let unknown =
        complaint("[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = \"1m\"\ncolour = \"red\"");
    assert!(
        unknown.starts_with("w.toml:4: unknown field `colour`"),
        "{unknown}"
    );
    let bare = complaint("[[disc]]\ncenter = [0, 1]\nradius = \"1m\"");
    assert!(
        bare.starts_with("w.toml:2: invalid type: integer"),
        "{bare}"
    );
    assert!(
        bare.ends_with(r#"expected a length in quotes, such as "-200mm" or "8m""#),
        "{bare}"
    );
    for (text, says) in [
        (
            "[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = 80",
            "w.toml:3: invalid type: integer `80`, expected a length in quotes, such as \"100mm\" or \"8m\"",
        ),
        (
            "[[box]]\ncenter = [\"0mm\", \"1m\"]\nsize = [\"1m\", \"1m\"]\nrotation = 1.5",
            "w.toml:4: invalid type: floating point `1.5`, expected an angle in quotes, such as \"15deg\"",
        ),
        (
            "disc = 5",
            "w.toml:1: invalid type: integer `5`, expected a sequence; write for example: [[disc]] center",
        ),
        (
            "[[disc]]\ncenter = [\"0mm\"]\nradius = \"1m\"",
            "write for example: [[disc]] center = [\"0mm\", \"500mm\"]",
        ),
    ] {
        let said = complaint(text);
        assert!(said.contains(says), "{said}");
    }
    let missing = complaint("name = \"x\"\n[[disc]]\nradius = \"1m\"");
    assert!(
        missing.starts_with("w.toml:2: missing field `center`"),
        "{missing}"
    );
    assert!(complaint("name = \"a\"\n=").starts_with("w.toml:2: "));
    let latin = World::parse(b"name = \"x\"\n# \xFF", "w.toml").unwrap_err();
    assert_eq!(
        latin.to_string(),
        "w.toml:2: not UTF-8 text; a world file is TOML"
    );
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = World::load(std::path::Path::new("no/such/world.toml")).unwrap_err();
    let line = error.to_string();
    assert!(
        line.starts_with("no/such/world.toml: cannot read the world file: "),
        "{line}"
    );
    assert_eq!(line.lines().count(), 1);
}

#[test]
fn an_endless_file_is_not_read_to_its_end() {
    let endless = std::path::Path::new("/dev/zero");
    if endless.exists() {
        assert!(matches!(
            World::load(endless),
            Err(crate::toml_file::TomlError::TooLong { .. })
        ));
    }
}

/// Marches along the ray and asks of each place whether it is covered.
fn marched(world: &World, origin: Point, bearing: BinaryAngle, most: f64) -> Option<f64> {
    let (from, along) = (Vector::centre_of(origin), Vector::along(bearing));
    let mut gone = 0.0;
    while gone <= most {
        let here = from.plus(Vector {
            x: along.x * gone,
            y: along.y * gone,
        });
        if world.obstacles.iter().any(|o| o.covers(here)) {
            return Some(gone);
        }
        gone += 0.25;
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn rays_end_where_marching_along_them_first_touches(
        seed in 0..1000_u64,
        x in -850..850_i32,
        y in -100..1100_i32,
        bearing in any::<u16>(),
    ) {
        let world = World::random(&Layout::default(), seed).unwrap();
        let (origin, bearing) = (Point::from_mm(x, y), BinaryAngle::from_bits(bearing));
        let cast = world.distance(origin, bearing, mm(1500));
        match (cast, marched(&world, origin, bearing, 1500.0)) {
            (Some(cast), Some(marched)) => {
                // Marching may step over a corner that the ray cuts, never the other way round.
                prop_assert!(cast <= marched + 1e-6, "{cast} vs {marched}");
                if cast < marched - 0.2501 {
                    let from = Vector::centre_of(origin);
                    let along = Vector::along(bearing);
                    let at = from.plus(Vector { x: along.x * cast, y: along.y * cast });
                    let touches = world.obstacles.iter().any(|o| {
                        let nudged = |by: f64| o.covers(at.plus(Vector { x: along.x * by, y: along.y * by }));
                        nudged(1e-6) || nudged(0.01)
                    });
                    prop_assert!(touches, "{cast} vs {marched}");
                }
            }
            (None, Some(marched)) => prop_assert!(marched > 1499.9, "missed {marched}"),
            _ => {}
        }
    }

    #[test]
    fn no_bytes_panic_and_every_complaint_is_one_line(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        if let Err(error) = World::parse(&bytes, "w.toml") {
            prop_assert_eq!(error.to_string().lines().count(), 1);
        }
    }

    #[test]
    fn no_spoilt_world_file_panics(at in 0..SMART_CAR.len(), bytes in prop::collection::vec(any::<u8>(), 0..6), cut in 0..6_usize) {
        let mut file = SMART_CAR.as_bytes().to_vec();
        let end = (at + cut).min(file.len());
        file.splice(at..end, bytes);
        match World::parse(&file, "w.toml") {
            Ok(world) => prop_assert!(!world.obstacles().is_empty()),
            Err(error) => prop_assert!(error.to_string().starts_with("w.toml:")),
        }
    }
}
