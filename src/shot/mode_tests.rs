//! Every mode of a morph, by its row.

use crate::node::list::MODES;
use crate::node::morph_mode::SHARED;
use crate::shot::scalar_tests::{loaded, prepared};

const SHAPES: &str = "frames = '1-9'\n[shape.a]\nbox = 1.2\n[shape.b]\nsphere = 0.7\nmove = [0.4, 0, 0]\n[morph]\n";

/// Its example is made ready, and is between the two objects in the middle of the shot: it bounds what both have inside.
#[test]
fn examples_run() {
    for mode in MODES {
        let scene = prepared(&format!("{SHAPES}{}", mode.example));
        let frame = scene.frame(5).unwrap_or_else(|error| panic!("{mode:?}: {error}"));
        let inside = |x: f64| frame.field.reference(glam::DVec3::new(x, 0.0, 0.0)) > 0.0;
        assert!(inside(0.2) && !inside(1.2) && !inside(-0.9), "{mode:?}");
    }
}

/// A key that a mode does not use is told, whichever mode it is.
#[test]
fn keys_of_others_are_refused() {
    for mode in MODES {
        let own = |name: &str| mode.parameters.iter().any(|key| key.name == name);
        assert!(mode.shared.iter().all(|name| SHARED.contains(name)), "{mode:?}");
        let others = MODES.iter().flat_map(|other| other.parameters).filter(|key| !own(key.name));
        for key in others {
            let text = format!("{SHAPES}from = 'a'\nto = 'b'\nmode = '{}'\n{} = 1", mode.key.name, key.name);
            let message = loaded(&text).expect_err("a key of another mode").to_string();
            assert!(message.contains(&format!("`{}` is", key.name)), "{mode:?}: {message}");
        }
    }
}
