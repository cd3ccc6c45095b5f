//! Which parts of a morph's objects become which, where the scene leaves it open.

use crate::field::Aabb;

/// Pairs of parts, from the places and sizes of their boxes in those of their wholes: the pair that lies nearest first,
/// each part once. Parts that are left over, where one side has more, go with the part that lies nearest to them.
/// In the order of the first side's parts, then of the second's.
pub(crate) fn matched(wholes: [Aabb; 2], parts: [&[Aabb]; 2]) -> Vec<[usize; 2]> {
    let cost = |[first, second]: [usize; 2]| {
        let [one, two] = [0, 1].map(|side: usize| {
            let (whole, part) = (wholes[side], parts[side][[first, second][side]]);
            let unit = 0.5 * whole.size().length().max(f64::MIN_POSITIVE);
            ((part.centre() - whole.centre()) / unit, 0.5 * part.size().length() / unit)
        });
        one.0.distance(two.0) + (one.1 - two.1).abs()
    };
    let mut all: Vec<[usize; 2]> =
        (0..parts[0].len()).flat_map(|first| (0..parts[1].len()).map(move |second| [first, second])).collect();
    // Stable: equals stay in the order of the scene.
    all.sort_by(|one, two| cost(*one).total_cmp(&cost(*two)));
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    let taken = |pairs: &[[usize; 2]], side: usize, part: usize| pairs.iter().any(|pair| pair[side] == part);
    for &[first, second] in &all {
        if !taken(&pairs, 0, first) && !taken(&pairs, 1, second) {
            pairs.push([first, second]);
        }
    }
    for &[first, second] in &all {
        if !taken(&pairs, 0, first) || !taken(&pairs, 1, second) {
            pairs.push([first, second]);
        }
    }
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::matched;
    use crate::field::Aabb;

    fn cube(x: f64, size: f64) -> Aabb {
        Aabb::new(DVec3::new(x - size, -size, -size), DVec3::new(x + size, size, size))
    }

    fn whole(parts: &[Aabb]) -> Aabb {
        parts.iter().copied().reduce(Aabb::union).expect("parts")
    }

    /// By place in the whole, wherever that stands and however large it is; by size where places are alike.
    #[test]
    fn the_nearest_go_together() {
        let (one, two) = ([cube(-1.0, 0.3), cube(1.0, 0.3)], [cube(17.0, 0.9), cube(11.0, 0.9)]);
        assert_eq!(matched([whole(&one), whole(&two)], [&one, &two]), [[0, 1], [1, 0]]);
        let (one, two) = ([cube(0.0, 1.0), cube(0.0, 0.2)], [cube(0.0, 0.3), cube(0.0, 1.0)]);
        assert_eq!(matched([whole(&one), whole(&two)], [&one, &two]), [[0, 1], [1, 0]]);
    }

    /// Where one becomes two, and two become one.
    #[test]
    fn none_is_left_over() {
        let (one, two) = ([cube(0.0, 0.5)], [cube(-1.0, 0.3), cube(1.0, 0.3)]);
        assert_eq!(matched([whole(&one), whole(&two)], [&one, &two]), [[0, 0], [0, 1]]);
        assert_eq!(matched([whole(&two), whole(&one)], [&two, &one]), [[0, 0], [1, 0]]);
    }
}
