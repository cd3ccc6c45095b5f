//! Files that make shapes: fonts, drawings, pictures, points; whole, cut and garbled.

mod support;

use std::fs;

use support::Workplace;

/// Cut, garbled and of another kind, each is an error with its name, or read all the same.
#[test]
fn broken_files_of_shapes_are_told() {
    let place = Workplace::new();
    let root = env!("CARGO_MANIFEST_DIR");
    for (key, file, more) in [
        ("text = 'Ag'\nfont", "fonts/noto-sans-semibold.ttf", ""),
        ("svg", "scenes/logo.svg", ""),
        ("image", "scenes/leaf.png", ""),
        ("height_field", "scenes/relief.png", ""),
        ("points", "scenes/points.csv", "radius = 0.1\n"),
    ] {
        let whole = fs::read(format!("{root}/{file}")).unwrap();
        let name = format!("x{}", &file[file.rfind('.').unwrap()..]);
        let scene = format!("[shape.s]\n{key} = '{name}'\n{more}");
        place.write("s.toml", &scene);
        let check = |content: &[u8]| {
            fs::write(place.path(&name), content).unwrap();
            place.hfvdb("check s.toml --no-estimate")
        };
        check(&whole).ok();
        check(b"").fails(1, &["s.toml:", &name]);
        check(&[0xff, 0x00, 0x80, 0x7f].repeat(200)).fails(1, &["s.toml:", &name]);
        // Whatever it is, it ends: right, or with an error that names the file.
        for part in 1..8 {
            let mut garbled = whole.clone();
            garbled[part * whole.len() / 8] ^= 0x55;
            for content in [&garbled[..], &whole[..part * whole.len() / 8]] {
                let told = check(content);
                assert!(
                    told.code == 0 || (told.code == 1 && told.stderr.contains(&name)),
                    "{name}, {part}: {}",
                    told.stderr
                );
            }
        }
    }
}
