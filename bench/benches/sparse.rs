//! The sparse signed distances of *two_hundred* in memory, against what users make them with (rows 5 and 6 of the
//! performance table): the loop with an accessor over the whole box, F only, once; and OpenVDB's level sets of
//! spheres, joined and taken away, pair by pair. All on two threads.
//!
//! `cargo bench -p hfvdb-bench --bench sparse [-- RESOLUTION...]`

use hfvdb_bench::clock::{pairs, timed};
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::rivals;
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::threads;

const PAIRS: usize = 11;
const THREADS: usize = 2;

fn bench(resolution: u32) {
    let row = |number| Row(number, "two_hundred", resolution);
    let [balls, holes] = scenes::two_hundred().numbers();
    let ready = || {
        let prepared = scenes::prepare("two_hundred", Sampling::OfBox(resolution));
        let content = prepared.frame(1).expect("a frame");
        (prepared, content)
    };
    threads(THREADS).install(|| {
        // From the scene's text on, as a process does it.
        let whole = || {
            timed(|| {
                let (prepared, content) = ready();
                scenes::band(&prepared, &content)
            })
        };
        let (theirs, grid) =
            timed(|| rivals::accessor_loop(&balls, &holes, resolution as i32, THREADS).expect("the rival runs"));
        println!("the loop with an accessor: {theirs:.2?} s, {} active voxels", grid.active_voxels());
        drop(grid);
        let once: Vec<_> = (0..PAIRS).map(|_| [whole().0, theirs]).collect();
        row("5").compare("from the text on, against the loop with an accessor", Goal::AtLeast(100.0), &once);

        let (prepared, content) = ready();
        let voxel_size = prepared.lattice.voxel_size.get();
        let rival = || rivals::spheres_by_csg(&balls, &holes, voxel_size).expect("the rival runs");
        println!("level sets of spheres: {} active voxels", rival().active_voxels());
        println!("ours: {} active voxels", scenes::band(&prepared, &content).band.active_voxels());
        let pairs = pairs(PAIRS, || timed(|| scenes::band(&prepared, &content)).0, || timed(rival).0);
        row("6").compare("against createLevelSetSphere, csgUnion, csgDifference", Goal::AtMost(0.8), &pairs);
    });
}

fn main() {
    hfvdb_bench::resolutions(&[512]).into_iter().for_each(bench);
}
