//! Twenty mistakes that are easily made, and what the program says to each: `docs/mistakes.md` is true.

mod support;

use support::Workplace;

/// The scenes of the page, each with the message that stands below it.
fn cases<'p>(page: &'p str) -> Vec<(&'p str, &'p str)> {
    let blocks: Vec<&str> = page.split("```").skip(1).step_by(2).collect();
    let pair = |pair: &[&'p str]| {
        let scene = pair[0].strip_prefix("toml\n").expect("a scene comes first");
        (scene, pair[1].strip_prefix("text\n").expect("a message comes after its scene"))
    };
    blocks.chunks_exact(2).map(pair).collect()
}

/// `UPDATE_DOCS=1` writes the messages anew.
#[test]
fn twenty_mistakes_and_what_is_said() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/mistakes.md");
    let page = std::fs::read_to_string(path).expect("the page is there");
    let cases = cases(&page);
    assert!(cases.len() >= 20, "{} mistakes", cases.len());
    let mut made = page.clone();
    for (scene, message) in &cases {
        let place = Workplace::new();
        place.write("scene.toml", scene);
        place.write("fox.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
        let run = place.hfvdb("check scene.toml --no-estimate");
        assert_ne!(run.code, 0, "this is no mistake:\n{scene}");
        let found = run.stderr.trim_end();
        made = made.replacen(
            &format!("{scene}```\n\n```text\n{message}```"),
            &format!("{scene}```\n\n```text\n{found}\n```"),
            1,
        );
    }
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(path, &made).expect("the page is written");
    }
    assert!(
        std::fs::read_to_string(path).expect("the page") == made,
        "docs/mistakes.md is out of date: UPDATE_DOCS=1 cargo test --test mistakes"
    );
}
