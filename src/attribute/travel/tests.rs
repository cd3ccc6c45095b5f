use super::*;
use crate::field::{Expression, Graph, Node, SetSystem};

fn field(make: impl FnOnce(&mut Graph) -> Node) -> Arc<dyn Field> {
    let mut graph = Graph::new();
    let node = make(&mut graph);
    Arc::new(Expression::new(&graph, node).keeping_values())
}

/// The box from one corner to another.
fn cuboid(min: DVec3, max: DVec3) -> Arc<dyn Field> {
    field(|graph| {
        let sides: Vec<Node> = (0..6)
            .map(|side| {
                let (axis, up) = (DVec3::AXES[side / 2], side % 2 == 0);
                graph.half_space(if up { axis } else { -axis }, if up { max.dot(axis) } else { -min.dot(axis) })
            })
            .collect();
        let node = graph.intersection(SetSystem::MinMax, &sides);
        graph.bounded(node, Aabb::new(min, max))
    })
}

fn ball(centre: DVec3, radius: f64) -> Arc<dyn Field> {
    field(|graph| {
        let node = crate::distance::accuracy::ball(graph, centre, radius);
        graph.bounded(node, Aabb::new(centre - radius, centre + radius))
    })
}

fn constant(value: f64) -> Arc<dyn Field> {
    field(|graph| graph.constant(value))
}

fn travel(solid: &dyn Field, sources: Sources, speed: &dyn Field, voxel: f64) -> Result<Travel, TravelError> {
    let aabb = solid.bounding_box().expect("it has one");
    let cancel = AtomicBool::new(false);
    Travel::new(&Journey { solid, aabb, sources, speed, voxel, cancel: &cancel })
}

/// Mean error over points of a box, by an exact time.
fn mean_error(travel: &Travel, within: Aabb, truth: impl Fn(DVec3) -> f64) -> f64 {
    let places = 0..4096;
    let error = |place: i32| {
        let share = DVec3::from([1, 16, 256].map(|step| (f64::from(place / step % 16) + 0.5) / 16.0));
        let at = within.min + share * within.size();
        (f64::from(travel.at(at)) - truth(at)).abs()
    };
    places.clone().map(error).sum::<f64>() / places.len() as f64
}

/// In a box whose speed is 1 on one side and 2 on the other, from its end: each side has its plane wave, and along the
/// border the fast one sends a wave into the slow one at the angle of total reflection.
#[test]
fn two_speeds_are_right_to_first_order() {
    let aabb = Aabb::new(DVec3::new(0.0, -0.5, -0.1), DVec3::new(1.0, 0.5, 0.1));
    let (solid, source) = (cuboid(aabb.min, aabb.max), cuboid(DVec3::splat(-2.0), DVec3::new(0.0, 2.0, 2.0)));
    let speed = field(|graph| {
        let y = graph.y();
        let below = graph.floor(y);
        graph.linear(below, 1.0, 2.0)
    });
    let truth = |p: DVec3| {
        let late = p.x / 2.0 + p.y.abs() * 0.75_f64.sqrt();
        if p.y < 0.0 { p.x.min(late) } else { p.x / 2.0 }
    };
    let error = |nodes: f64| {
        let found = travel(&*solid, Sources::Solids(vec![Arc::clone(&source)]), &*speed, 1.0 / nodes).expect("times");
        mean_error(&found, aabb, truth)
    };
    let (coarse, fine) = (error(32.0), error(64.0));
    assert!(coarse <= 1.5 / 32.0 && fine <= 1.5 / 64.0, "{coarse} {fine}");
    assert!(libm::log2(coarse / fine) > 0.7, "{coarse} {fine}");
}

/// Around an obstacle: behind it the way is that of a string that is pulled tight around its edge.
#[test]
fn ways_stay_inside() {
    let far = DVec3::new(1.0, 1.0, 0.1);
    let solid = field(|graph| {
        let own = [cuboid(-far, far), cuboid(DVec3::new(-0.1, -2.0, -1.0), DVec3::new(0.1, 0.5, 1.0))];
        let [whole, wall] = own.map(|field| graph.field(field));
        let node = graph.difference(SetSystem::MinMax, whole, &[wall]);
        graph.bounded(node, Aabb::new(-far, far))
    });
    // Over the wall's two upper edges, from a ball of radius 0.1.
    let sources = Sources::Solids(vec![ball(DVec3::new(-0.6, -0.5, 0.0), 0.1)]);
    let found = travel(&*solid, sources, &*constant(0.5), 1.0 / 48.0).expect("times");
    let way = DVec3::new(0.5, 1.0, 0.0).length() - 0.1 + 0.2 + DVec3::new(0.5, 1.0, 0.0).length();
    let time = f64::from(found.at(DVec3::new(0.6, -0.5, 0.0)));
    assert!((time - way / 0.5).abs() < 0.05 * way / 0.5, "{time} {}", way / 0.5);
}

/// From the surface inward the time is the depth over the speed, and outside that of the surface.
#[test]
fn from_the_surface_the_time_is_the_depth() {
    let solid = ball(DVec3::splat(0.01), 1.0);
    let found = travel(&*solid, Sources::Surface, &*constant(4.0), 1.0 / 24.0).expect("times");
    for radius in [0.3, 0.5, 0.8, 0.95] {
        let at = DVec3::splat(0.01) + DVec3::new(0.48, 0.6, 0.64) * radius;
        assert!((f64::from(found.at(at)) - (1.0 - radius) / 4.0).abs() < 1.0 / 24.0 / 4.0, "{radius} {}", found.at(at));
    }
    for far in [1.02, 1.5, 40.0] {
        assert!((0.0..0.02).contains(&found.at(DVec3::splat(far))), "{far}");
    }
    let [range] = found.sampler().bounds(&Aabb::new(DVec3::ZERO, DVec3::ONE));
    assert!(range.lo >= 0.0 && (0.2..0.26).contains(&range.hi), "{range:?}");
}

#[test]
fn threads_change_no_bit() {
    let (solid, source) = (ball(DVec3::ZERO, 1.0), ball(DVec3::X, 0.3));
    let speed = field(|graph| {
        let x = graph.x();
        graph.linear(x, 0.4, 1.0)
    });
    let times = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let sources = Sources::Solids(vec![Arc::clone(&source)]);
        let found = pool.install(|| travel(&*solid, sources, &*speed, 0.06)).expect("times");
        found.times.iter().map(|time| time.to_bits()).collect::<Vec<_>>()
    };
    assert!(times(1) == times(2));
}

#[test]
fn what_cannot_be_travelled_is_told_with_its_place() {
    let solid = ball(DVec3::ZERO, 1.0);
    let slope = field(|graph| graph.x());
    let found = travel(&*solid, Sources::Surface, &*slope, 0.1);
    let wrong = |position: DVec3, speed: f32| position.x <= 1e-9 && (f64::from(speed) - position.x).abs() < 1e-6;
    assert!(matches!(found, Err(TravelError::Speed { position, speed }) if wrong(position, speed)));
    let nothing = travel(&*solid, Sources::Surface, &*constant(f64::NAN), 0.1);
    assert!(matches!(nothing, Err(TravelError::Speed { speed, .. }) if speed.is_nan()));
    let away = Sources::Solids(vec![ball(DVec3::X * 5.0, 0.5)]);
    assert_eq!(travel(&*solid, away, &*constant(1.0), 0.1).err(), Some(TravelError::NoSource));
    let two = field(|graph| {
        let both = [ball(DVec3::X * -2.0, 1.0), ball(DVec3::X * 2.0, 1.0)].map(|field| graph.field(field));
        let node = graph.union(SetSystem::MinMax, &both);
        graph.bounded(node, Aabb::new(DVec3::new(-3.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0)))
    });
    let one_end = Sources::Solids(vec![ball(DVec3::X * -3.0, 0.5)]);
    let found = travel(&*two, one_end, &*constant(1.0), 0.1);
    assert!(matches!(found, Err(TravelError::Unreached { position, nodes, .. }) if position.x > 0.9 && nodes > 3000));
}
