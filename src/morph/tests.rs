//! The promises of a morph, on exact shapes.

use std::sync::Arc;

use glam::DVec3;

use super::exact::Exact;
use super::*;
use crate::attribute::Constant;
use crate::distance::Distance;

fn object(exact: Arc<Exact>, motion: Motion) -> MorphObject {
    MorphObject {
        surface: exact.clone(),
        distance: exact as Arc<dyn Distance>,
        colour: Arc::new(Constant::new([0.5, 0.5, 0.5])),
        motion,
    }
}

fn still(exact: Arc<Exact>) -> MorphObject {
    object(exact, Motion::default())
}

fn morph(from: Arc<Exact>, to: Arc<Exact>) -> Morph {
    Morph::new(still(from), still(to), Settings::default()).expect("a morph")
}

fn frames(count: usize) -> Vec<f64> {
    (0..count).map(|frame| frame as f64 / (count - 1) as f64).collect()
}

fn pairs() -> Vec<(&'static str, Arc<Exact>, Arc<Exact>)> {
    let two = Exact::Apart(vec![(*Exact::ball(-0.9, 0.4)).clone(), (*Exact::ball(0.9, 0.4)).clone()]);
    vec![
        ("apart", Exact::cube(-1.2, 0.5), Exact::ball(1.2, 0.5)),
        ("concentric", Exact::cube(0.0, 0.8), Exact::ball(0.0, 0.6)),
        ("cube to torus", Exact::cube(0.0, 0.8), Exact::torus(1.0, 0.3)),
        ("small in big", Exact::ball(0.3, 0.15), Exact::cube(0.0, 1.0)),
        ("one into two", Exact::cube(0.0, 0.6), Arc::new(two)),
        (
            "thin plates crossing",
            Exact::block(0.0, DVec3::new(1.0, 1.0, 0.04)),
            Exact::block(0.0, DVec3::new(0.04, 1.0, 1.0)),
        ),
        ("far apart", Exact::ball(-4.0, 0.5), Exact::cube(4.0, 0.5)),
        (
            "into a shell",
            Exact::ball(0.0, 0.4),
            Arc::new(Exact::Shell { of: Box::new((*Exact::ball(0.0, 1.0)).clone()), half: 0.03 }),
        ),
        ("overlapping copies", Exact::cube(-0.2, 0.5), Exact::cube(0.2, 0.5)),
    ]
}

#[test]
fn explore() {
    for (name, from, to) in pairs() {
        let begun = std::time::Instant::now();
        let morph = morph(from, to);
        let planned = begun.elapsed();
        let begun = std::time::Instant::now();
        let report = morph.report(&frames(48));
        println!(
            "== {name}: plan {planned:?} report {:?} D {:.3} cell {:.4} cells {} extent {:?}",
            begun.elapsed(),
            morph.plan().unit,
            morph.plan().grid.edge(),
            morph.plan().grid.cell_count(),
            morph.plan().extent
        );
        let changes = &morph.plan().changes;
        let mean = changes.iter().sum::<f64>() / changes.len() as f64;
        println!("  plan: max/mean {:.3}", changes.iter().cloned().fold(0.0, f64::max) / mean);
        println!(
            "  frames: median {:.5} largest/median {:.3} first {:.3} last {:.3}",
            report.median_change,
            report.largest_over_median,
            report.frames[1].change / report.median_change,
            report.frames[47].change / report.median_change
        );
        let worst = report.frames.iter().map(|f| (f.volume / f.target.unwrap() - 1.0).abs()).fold(0.0, f64::max);
        println!("  volume off by at most {:.2e}", worst);
        for f in report.frames.iter().step_by(4) {
            println!(
                "    tau {:.3} t {:.4} a0 {:.5} vol {:.4} target {:.4} change/med {:.3}",
                f.time,
                f.t,
                f.a0,
                f.volume,
                f.target.unwrap(),
                f.change / report.median_change
            );
        }
    }
}
