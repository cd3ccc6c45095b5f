//! Shapes written in place: the same as with names, to any depth that is allowed.

use super::tests::{only, problems};
use super::trap_tests::field;
use crate::field::Field;
use crate::field::tests::Samples;
use crate::field::{Aabb, Expression};
use glam::DVec3;

fn same_everywhere(one: &Expression, other: &Expression) {
    let mut samples = Samples::new(7);
    for _ in 0..500 {
        let place = samples.within(&Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0)));
        assert_eq!(one.reference(place), other.reference(place), "at {place}");
    }
}

#[test]
fn shapes_in_place_are_those_of_names() {
    let nested = "[shape.c]\nunion = [{ sphere = 1, move = [1, 0, 0] }, { difference = ['a', { box = 1 }] }, 'b']\n\
                  [shape.a]\nbox = [1, 2, 3]\n[shape.b]\nextrude = { difference = [{ circle = 1 }, 'hole'] }\n\
                  [shape.hole]\nrectangle = 0.4\n[output]\nshape = 'c'\n";
    let named = "[shape.c]\nunion = ['ball', 'rest', 'b']\n[shape.ball]\nsphere = 1\nmove = [1, 0, 0]\n[shape.rest]\n\
                 difference = ['a', 'cube']\n[shape.cube]\nbox = 1\n[shape.a]\nbox = [1, 2, 3]\n[shape.b]\n\
                 extrude = 'plate'\n[shape.plate]\ndifference = ['disk', 'hole']\n[shape.disk]\ncircle = 1\n\
                 [shape.hole]\nrectangle = 0.4\n[output]\nshape = 'c'\n";
    same_everywhere(&field(nested), &field(named));
}

#[test]
fn errors_in_place_say_where() {
    let scene = |inner: &str| {
        format!("[shape.a]\nunion = [{{ sphere = 1 }}, {{ difference = ['b', {inner}] }}]\n[shape.b]\nbox = 1\n")
    };
    let cases = [
        ("{ sphere = -1 }", "2:58 `shape.a.union[1].difference[1].sphere` must be greater than 0"),
        ("{ sphre = 1 }", "2:49 unknown key `sphre` in `shape.a.union[1].difference[1]`; did you mean `sphere`?"),
        ("'c'", "2:48 there is no `shape.c`; did you mean `a`?"),
        (
            "{ circle = 1 }",
            "2:47 `difference` needs solids, and `a.union[1].difference[1]` is a shape of the plane; make it a \
          solid with `extrude`, `revolve` or `sweep`",
        ),
        (
            "{ union = ['a', 'b'] }",
            "2:26 `a` is made from itself; the way is a → a.union[1] → a.union[1].difference[1] → a",
        ),
    ];
    for (inner, wanted) in cases {
        only(&scene(inner), wanted);
    }
}

/// So many shapes around a ball, each in a list or as the value itself.
fn deep(levels: usize, open: &str, close: &str) -> String {
    format!("{}{{ sphere = 1 }}{}", open.repeat(levels - 1), close.repeat(levels - 1))
}

#[test]
fn sixty_four_levels_and_no_more() {
    let complements = |levels| format!("[shape.a]\nunion = [{}]\n", deep(levels, "{ complement = ", " }"));
    same_everywhere(&field(&complements(63)), &field("[shape.a]\nsphere = 1\n"));
    assert_eq!(problems(&complements(63)), [] as [&str; 0]);
    let json = |levels| {
        format!(
            "{{ \"shape\": {{ \"a\": {{ \"union\": [{}] }} }} }}",
            deep(levels, "{ \"union\": [", "] }").replace("sphere =", "\"sphere\":")
        )
    };
    same_everywhere(&field(&json(64)), &field("[shape.a]\nsphere = 1\n"));
    let found = problems(&json(65));
    assert!(
        found.len() == 1 && found[0].ends_with("; give one of the shapes on the way a name: [shape.NAME]"),
        "{found:?}"
    );
    let values = deep(65, "{ \"complement\": ", " }").replace("sphere =", "\"sphere\":");
    only(
        &format!("{{ \"shape\": {{ \"a\": {{ \"union\": [{values}] }} }} }}"),
        "1:1055 shapes in place stand more than 64 deep in one another; give one on the way a name: [shape.NAME]",
    );
    let lists = |levels| format!("[shape.a]\nunion = [{}]\n", deep(levels, "{ union = [", "] }"));
    same_everywhere(&field(&lists(42)), &field("[shape.a]\nsphere = 1\n"));
    let found = problems(&lists(1000));
    assert!(found.len() == 1 && found[0].contains("nested too deeply; give one"), "{found:?}");
}
