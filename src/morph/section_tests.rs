//! What is promised of one section of a morph: the papers' formula, its slopes and its bounds.

use super::section::Kernel;
use super::tests::random;
use super::*;
use crate::field::Interval;

/// The formulas as the papers print them: R₀ with its plain root, the displacement by r.
fn printed(section: &Section, f1: f64, f2: f64) -> f64 {
    let Section { t, time_scale: s, slab, a0, a1, a2, a3, round } = *section;
    let or = |a: f64, b: f64| a + b + (a * a + b * b).sqrt();
    let and = |a: f64, b: f64| a + b - (a * a + b * b).sqrt();
    let displacement = |f1: f64, f2: f64, f3: f64, [a1, a2, a3]: [f64; 3]| {
        let r1 = (f1 / a1).powi(2) + (f2 / a2).powi(2);
        let r2 = if f3 > 0.0 { (f3 / a3).powi(2) } else { 0.0 };
        let r = if r2 > 0.0 { (r1 / (r1 + r2)).sqrt() } else { 1.0 };
        if r < 1.0 { (1.0 - r * r).powi(3) / (1.0 + r * r) } else { 0.0 }
    };
    let cylinder = |f: f64, cut: f64, t: f64| {
        let rounded = |round: Round| {
            let reach = [round.reach, round.reach, round.a3];
            round.a0 * displacement(f, cut, s * (t + round.depth), reach)
        };
        and(f, cut) + round.map_or(0.0, rounded)
    };
    let (g1, g2) = (cylinder(f1, -s * t, t), cylinder(f2, s * (t - 1.0), 1.0 - t));
    or(g1, g2) + a0 * displacement(g1, g2, and(s * (t - slab[0]), s * (slab[1] - t)), [a1, a2, a3])
}

fn sections() -> Vec<Section> {
    let round = Some(Round { a0: -0.2, reach: 0.5, a3: 0.7, depth: 0.3 });
    let mut sections = Vec::new();
    for t in [0.0, 0.01, 0.5, 0.9, 1.0] {
        sections.push(Section { a0: 2.0 * 0.25 * t * (1.0 - t), ..Volume::default().section(t, 0.0) });
        sections.push(Section { a0: 30.0, ..Volume { bridge: 1.5.into(), ..Volume::default() }.section(t, 0.0) });
        sections.push(Numbers::default().section(t));
        sections.push(Numbers { a: [-0.4, 0.5, 2.0, 1.0], slab: [-0.5, 1.2], round, time_scale: 0.7 }.section(t));
    }
    sections
}

#[test]
fn a_section_is_the_papers_formula() {
    let mut next = random(4);
    for section in sections() {
        let kernel = Kernel::<f64>::new(&section);
        for _ in 0..200 {
            let (f1, f2) = (next() * 3.0 - 2.0, next() * 3.0 - 2.0);
            let (ours, theirs) = (kernel.value(f1, f2), printed(&section, f1, f2));
            assert!((ours - theirs).abs() < 1e-12 * (1.0 + section.a0.abs()), "{ours} {theirs} {section:?}");
        }
    }
}

#[test]
fn slopes_are_those_of_the_values() {
    let mut next = random(5);
    for section in sections() {
        let kernel = Kernel::<f64>::new(&section);
        for _ in 0..200 {
            let (f1, f2, h) = (next() * 2.0 - 1.5, next() * 2.0 - 1.5, 1e-5);
            let slopes = kernel.slopes(f1, f2);
            let by_first = (kernel.value(f1 + h, f2) - kernel.value(f1 - h, f2)) / (2.0 * h);
            let by_second = (kernel.value(f1, f2 + h) - kernel.value(f1, f2 - h)) / (2.0 * h);
            // At t = 0 and t = 1 a cylinder has a crease where its distance is 0.
            if f1.abs() > 1e-3 && f2.abs() > 1e-3 {
                assert!((slopes.by_first - by_first).abs() < 1e-5 * (1.0 + section.a0.abs()), "{section:?} {f1} {f2}");
                assert!(
                    (slopes.by_second - by_second).abs() < 1e-5 * (1.0 + section.a0.abs()),
                    "{section:?} {f1} {f2}"
                );
            }
            assert!(slopes.by_first.abs() + slopes.by_second.abs() <= kernel.greatest_slope());
        }
    }
}

#[test]
fn a_sections_bounds_hold_its_values() {
    let mut next = random(6);
    for section in sections() {
        let (kernel, fast) = (Kernel::<f64>::new(&section), Kernel::<f32>::new(&section));
        for _ in 0..60 {
            let size = 10f64.powf(-3.0 * next());
            let mut interval = || {
                let lo = next() * 2.0 - 1.5;
                Interval::new(lo, lo + next() * size)
            };
            let (first, second) = (interval(), interval());
            let bounds = kernel.bounds(first, second);
            for _ in 0..20 {
                let within = |interval: Interval, share: f64| interval.lo + (interval.hi - interval.lo) * share;
                let (f1, f2) = (within(first, next()), within(second, next()));
                assert!(bounds.contains(kernel.value(f1, f2)), "{section:?}");
                assert!(bounds.contains(f64::from(fast.value(f1 as f32, f2 as f32))), "{section:?}");
            }
        }
    }
}
