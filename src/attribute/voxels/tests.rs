use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::grid::block_order;

/// Voxels as blocks, in an order of their own.
fn blocks(voxels: impl IntoIterator<Item = (IVec3, LinearRgb)>) -> ValueBlocks<3> {
    let mut blocks = ValueBlocks {
        voxel_size: 0.5,
        origin: DVec3::new(0.25, -3.0, 1.0),
        origins: vec![],
        values: vec![],
        active: vec![],
    };
    let mut places = FxHashMap::default();
    for (voxel, colour) in voxels {
        let block = *places.entry(block_origin(voxel)).or_insert_with(|| {
            blocks.origins.push(block_origin(voxel));
            blocks.values.push([[f32::NAN; 3]; BLOCK_VOXELS]);
            blocks.active.push([0; 8]);
            blocks.origins.len() - 1
        });
        let offset = voxel_offset(voxel);
        blocks.values[block][offset] = colour;
        blocks.active[block][offset >> 6] |= 1 << (offset & 63);
    }
    blocks
}

/// The voxels of a box for which a test holds, coloured by where they are.
fn coloured(reach: i32, holds: impl Fn(IVec3) -> bool) -> Vec<(IVec3, LinearRgb)> {
    let side = -reach..=reach;
    let all =
        side.clone().flat_map(|x| side.clone().flat_map(move |y| (-reach..=reach).map(move |z| IVec3::new(x, y, z))));
    let colour = |voxel: IVec3| {
        let half = if voxel.x < 0 { 0.0 } else { 1.0 };
        let dust = (voxel.x * 31 + voxel.y * 17 + voxel.z * 7).rem_euclid(64) as f32 / 63.0;
        [half, dust, (voxel.z + reach) as f32 / (2 * reach) as f32]
    };
    all.filter(|voxel| holds(*voxel)).map(|voxel| (voxel, colour(voxel))).collect()
}

fn ball(radius: i32) -> Vec<(IVec3, LinearRgb)> {
    coloured(radius, |voxel| voxel.length_squared() <= radius * radius)
}

fn shell(radius: i32) -> Vec<(IVec3, LinearRgb)> {
    coloured(radius, |voxel| (((radius - 5) * (radius - 5))..=radius * radius).contains(&voxel.length_squared()))
}

/// Colours at positions in voxels.
fn sampled(colours: &VoxelValues<3>, positions: &[DVec3]) -> Vec<LinearRgb> {
    let mut sampler = colours.sampler();
    let mut all = Vec::new();
    for positions in positions.chunks(BATCH) {
        let mut points = Points::new(positions[0] * colours.voxel_size + colours.origin);
        for at in positions {
            points.push(((*at - positions[0]) * colours.voxel_size).as_vec3());
        }
        let mut out = [[f32::NAN; 3]; BATCH];
        sampler.sample(&points, &mut out);
        all.extend_from_slice(&out[..positions.len()]);
    }
    all
}

/// Positions over a cube, by a low-discrepancy sequence, in parts of a voxel that 32 bits hold.
fn positions(count: usize, reach: f64) -> Vec<DVec3> {
    let step = DVec3::new(0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3);
    (0..count).map(|i| (((step * i as f64).fract() * 2.0 - 1.0) * reach * 64.0).round() / 64.0).collect()
}

fn is_inside(voxels: &[(IVec3, LinearRgb)], at: DVec3) -> bool {
    voxels.iter().any(|(voxel, _)| *voxel == at.round().as_ivec3())
}

fn potential(power: u32) -> Outside {
    Outside::Potential(Power::new(power).expect("one of POWERS"))
}

/// Eq. 4, term by term.
fn direct(voxels: &[(IVec3, LinearRgb)], at: DVec3, power: i32) -> DVec3 {
    let weight = |voxel: IVec3| at.distance(voxel.as_dvec3()).powi(-power);
    let sum: DVec3 = voxels.iter().map(|(voxel, colour)| weight(*voxel) * Vec3::from(*colour).as_dvec3()).sum();
    sum / voxels.iter().map(|(voxel, _)| weight(*voxel)).sum::<f64>()
}

/// The greatest difference between two colours, by channel.
fn range(voxels: &[(IVec3, LinearRgb)]) -> DVec3 {
    let colours = voxels.iter().map(|(_, colour)| Vec3::from(*colour).as_dvec3());
    colours.clone().reduce(DVec3::max).unwrap() - colours.reduce(DVec3::min).unwrap()
}

#[test]
fn the_potential_is_within_its_bound_of_the_direct_sum() {
    let mut greatest = 0.0_f64;
    for voxels in [ball(12), shell(16), coloured(2, |voxel| voxel == IVec3::ONE)] {
        for power in POWERS {
            let colours = VoxelValues::new(blocks(voxels.iter().copied()), potential(power)).unwrap();
            let bound = range(&voxels) * (RELATIVE_ERROR / (1.0 - RELATIVE_ERROR)) + 1e-5;
            let mut positions = positions(300, 20.0);
            positions.extend(self::positions(40, 300.0));
            // Close to one another, as the feet of a block are: near to the volume, in a gap and far away.
            for middle in [DVec3::new(9.0, 9.0, 11.0), DVec3::new(3.0, -4.0, 2.0), DVec3::new(45.0, 20.0, -9.0)] {
                positions.extend(self::positions(200, 3.0).into_iter().map(|at| at + middle));
            }
            positions.retain(|at| !is_inside(&voxels, *at));
            let found = sampled(&colours, &positions);
            for (at, found) in positions.into_iter().zip(found) {
                let error = (Vec3::from(found).as_dvec3() - direct(&voxels, at, power as i32)).abs();
                assert!(error.cmple(bound).all(), "power {power} at {at}: {error}, more than {bound}");
                greatest = greatest.max((error / range(&voxels).max(DVec3::splat(1e-3))).max_element());
            }
        }
    }
    // Far within the bound: no level of 8 bits changes for it by more than rounding does.
    assert!(greatest < 0.5 / 255.0, "{greatest} of the range");
}

#[test]
fn the_potential_far_away_is_the_mean() {
    let voxels = ball(12);
    let mean = voxels.iter().map(|(_, colour)| Vec3::from(*colour).as_dvec3()).sum::<DVec3>() / voxels.len() as f64;
    for power in POWERS {
        let colours = VoxelValues::new(blocks(voxels.iter().copied()), potential(power)).unwrap();
        for colour in sampled(&colours, &[DVec3::new(1e7, 0.0, 0.0), DVec3::new(-4e7, 3e7, 1e6)]) {
            assert!(Vec3::from(colour).as_dvec3().distance(mean) < 1e-4, "power {power}: {colour:?}, not {mean}");
        }
    }
}

/// Trilinear sampling gives a linear colour back, also at the border, where corners have no voxel on one side only
/// along the axis on which the colour does not change.
#[test]
fn inside_a_linear_colour_is_itself() {
    let linear = |at: DVec3| (DVec3::new(0.5, 0.1, 0.2) + at * 0.02).as_vec3();
    let voxels = ball(9).into_iter().map(|(voxel, _)| (voxel, linear(voxel.as_dvec3()).to_array()));
    for outside in [Outside::Foot, potential(4)] {
        let colours = VoxelValues::new(blocks(voxels.clone()), outside).unwrap();
        let positions = positions(700, 4.0);
        for (at, found) in positions.iter().zip(sampled(&colours, &positions)) {
            assert!(Vec3::from(found).distance(linear(*at)) < 1e-6, "{at}: {found:?}");
        }
    }
}

#[test]
fn outside_the_foot_has_the_colour_and_nothing_jumps_at_the_border() {
    let voxels = shell(16);
    let colours = VoxelValues::new(blocks(voxels.iter().copied()), Outside::Foot).unwrap();
    let positions: Vec<DVec3> = positions(600, 24.0).into_iter().filter(|at| !is_inside(&voxels, *at)).collect();
    let half = DVec3::splat(0.5);
    for (at, found) in positions.iter().zip(sampled(&colours, &positions)) {
        let foot = |voxel: IVec3| at.clamp(voxel.as_dvec3() - half, voxel.as_dvec3() + half);
        let least = voxels.iter().map(|(voxel, _)| at.distance_squared(foot(*voxel))).fold(f64::INFINITY, f64::min);
        let nearest = voxels.iter().filter(|(voxel, _)| at.distance_squared(foot(*voxel)) == least);
        let nearest = nearest.min_by_key(|(voxel, _)| voxel.to_array()).unwrap().0;
        assert_eq!(found, colours.volume.trilinear(foot(nearest)), "{at}");
        // Just inside of the border the colour is that of the foot.
        let inside = foot(nearest).lerp(nearest.as_dvec3(), 1e-6);
        let there = sampled(&colours, &[inside])[0];
        assert!(Vec3::from(found).distance(Vec3::from(there)) < 1e-4, "{at}: {found:?} {there:?}");
    }
}

#[test]
fn the_order_of_blocks_does_not_count() {
    let mut sorted = blocks(shell(16));
    let mut order: Vec<usize> = (0..sorted.origins.len()).collect();
    order.sort_by_key(|block| block_order(sorted.origins[*block]));
    sorted.values = order.iter().map(|block| sorted.values[*block]).collect();
    sorted.active = order.iter().map(|block| sorted.active[*block]).collect();
    sorted.origins = order.iter().map(|block| sorted.origins[*block]).collect();
    let positions = positions(600, 24.0);
    for outside in [Outside::Foot, potential(4)] {
        let found = [blocks(shell(16)), sorted.clone()]
            .map(|blocks| sampled(&VoxelValues::new(blocks, outside).unwrap(), &positions));
        assert_eq!(found[0], found[1]);
    }
}

#[test]
fn without_active_voxels_there_are_no_colours() {
    let mut none = blocks(ball(2));
    none.active.iter_mut().for_each(|mask| *mask = [0; 8]);
    assert!(VoxelValues::new(none, Outside::Foot).is_none());
    assert!(VoxelValues::new(blocks([]), Outside::Foot).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Wherever voxels are, at the ends of what a file can name too, the nearest is found.
    #[test]
    fn the_nearest_of_strays(
        strays in prop::collection::vec(any::<[i32; 3]>().prop_map(IVec3::from), 1..30),
        middle in any::<[i32; 3]>(),
        ways in prop::collection::vec(prop::array::uniform3(-9..9), 1..5),
        step in 0..30,
    ) {
        let blocks = blocks(strays.iter().map(|voxel| (*voxel, [0.0; 3])));
        let colours = VoxelValues::new(blocks, Outside::Foot).unwrap();
        let half = DVec3::splat(0.5);
        // Points that stand together, or as far apart as the strays.
        let place = |way: &[i32; 3]| IVec3::from(middle).as_dvec3() + IVec3::from(*way).as_dvec3() * f64::from(1 << step);
        let mut points: Vec<(DVec3, usize)> = ways.iter().map(place).zip(0..).collect();
        let mut found = vec![];
        let mut nearest = Nearest::new(&colours.volume, &colours.tree);
        nearest.find(&mut points, &mut |at, place, voxel| found.push((at, place, voxel)));
        prop_assert_eq!(found.len(), ways.len());
        for (at, index, voxel) in found {
            prop_assert_eq!(at, place(&ways[index]));
            let key = |voxel: IVec3| {
                let foot = at.clamp(voxel.as_dvec3() - half, voxel.as_dvec3() + half);
                (at.distance_squared(foot), voxel.to_array())
            };
            let least = strays.iter().copied().min_by(|a, b| key(*a).partial_cmp(&key(*b)).unwrap()).unwrap();
            prop_assert_eq!(voxel, least);
        }
    }
}
