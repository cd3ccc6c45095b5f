//! Scenes that are right, and scenes that are wrong in every way there is.

use std::path::PathBuf;
use std::sync::Arc;

use super::load::load_with;
use super::*;

fn load_text(text: &str, overrides: &Overrides) -> Result<Model, Diagnostics> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let name = if text.trim_start().starts_with('{') { "scene.json" } else { "scene.toml" };
    let source = Source::Text { name: name.into(), text: text.into(), folder };
    load_with(&source, overrides, Arc::new(|name| (name == "SHOT").then(|| "/shots/010".into())))
}

fn model(text: &str) -> Model {
    load_text(text, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn show() {
    for text in [
        "[shape.a]\nsphre = 2\nbx=1\n",
        "[shape.a]\nsphere=-1\nbox=2\n",
        "[shape.a]\nunion=['b']\n[shape.b]\nunion=['a', 'cc']\nmove=[1,2]",
        "[shape.a]\nformula = 'x +* 1'\ncolor='redd'\n",
    ] {
        println!("{}", load_text(text, &Overrides::default()).unwrap_err());
    }
    for name in builtin_names() {
        let model = load(&Source::Builtin(name.into()), &Overrides::default());
        match model {
            Ok(model) => println!(
                "{:#?}",
                model.settings.iter().map(|s| format!("{} = {} {:?}", s.name, s.value, s.origin)).collect::<Vec<_>>()
            ),
            Err(e) => println!("{e}"),
        }
    }
}
