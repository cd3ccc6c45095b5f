//! Nodes: everything that a scene can name, from its text to its field, colours and scalars at one moment.
//!
//! [`load`] checks a scene's text against [`keys`] into a [`Model`]. Knows no frames, no voxels, and writes no files.

pub(crate) mod applied;
pub(crate) mod argument;
mod as_it_is;
pub(crate) mod assets;
pub(crate) mod attributes;
pub(crate) mod bend;
pub(crate) mod blending;
pub(crate) mod cache;
mod catalogue;
mod compose;
pub(crate) mod conformal;
pub(crate) mod copied;
pub(crate) mod corners;
pub(crate) mod curves;
pub(crate) mod depth;
pub(crate) mod direct;
pub(crate) mod displacement;
mod example;
pub(crate) mod extent;
pub(crate) mod grading;
pub(crate) mod grain;
mod hash;
pub(crate) mod id;
pub(crate) mod imports;
pub(crate) mod inside;
pub(crate) mod insides;
pub(crate) mod keeping;
pub(crate) mod kernels;
pub mod keys;
pub(crate) mod lattice;
pub(crate) mod load;
pub(crate) mod measured;
pub(crate) mod minimal;
pub(crate) mod model;
pub(crate) mod morph_mode;
pub(crate) mod morphed;
pub(crate) mod octaves;
pub(crate) mod operation;
mod origin;
pub(crate) mod own_box;
pub(crate) mod paint;
pub(crate) mod painted;
pub(crate) mod parameter;
pub(crate) mod pattern;
pub(crate) mod placed;
mod probe;
pub(crate) mod profile;
pub(crate) mod promises;
mod read;
pub(crate) mod reading;
mod reference;
mod schema;
pub(crate) mod solid;
pub(crate) mod source;
pub(crate) mod spec;
pub(crate) mod system;
pub(crate) mod table;
pub(crate) mod variation;
mod volume;

#[cfg(test)]
mod conformal_tests;
#[cfg(test)]
mod damage_tests;
#[cfg(test)]
mod grading_tests;
#[cfg(test)]
mod import_tests;
#[cfg(test)]
mod names_tests;
#[cfg(test)]
mod nesting_tests;
#[cfg(test)]
mod operation_tests;
#[cfg(test)]
mod reading_tests;
#[cfg(test)]
mod row_tests;
#[cfg(test)]
mod shape_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trap_tests;

pub use as_it_is::{Beside, Files};
pub use cache::Cache;
pub use catalogue::{Entry, Parameter, catalogue, nodes_page};
pub use compose::{Part, Scene, Value, morph_of_meshes};
pub use example::{node_names, node_scene};
pub use load::load;
pub use model::*;
pub use origin::Source;
#[cfg(feature = "cli")]
pub(crate) use origin::text_of;
pub use probe::{Probe, Reading};
pub use reference::reference;
pub use schema::schema;

/// Tables of nodes, each row a file with a `NODE`: a line is all that a new one needs.
macro_rules! nodes {
    ($($(#[$doc:meta])* $table:ident: $row:ty = { $($room:ident $title:literal: $($file:ident)*;)* })*) => {
        $($(
            pub(crate) mod $room {
                $(pub(crate) mod $file;)*
            }
        )*)*
        /// The tables.
        pub(crate) mod list {
            use super::{morph_mode::ModeSpec, source::Source, spec::Spec};
            $($(#[$doc])* pub static $table: &[$row] = &[$($(super::$room::$file::NODE,)*)*];)*

            /// The rooms: each one's table, its title, and the names of its nodes.
            pub static ROOMS: &[(&str, &str, &[&str])] = &[$($(
                (stringify!($table), $title, &[$(super::$room::$file::NODE.key.name,)*]),
            )*)*];
        }
    };
}

nodes! {
    /// What a shape can be: exactly one of these. In the order of the documentation.
    MAKERS: Spec = {
        primitive "Solids":
            sphere
            cuboid
            ellipsoid
            superellipsoid
            cylinder
            cone
            wedge
            torus
            supertoroid
            capsule
            half_space
            slab
            infinite_cylinder
            infinite_cone
            corner
            rounded_box
            chamfered_box
            box_frame
            hollow_box
            cut_sphere
            cap
            hollow_sphere
            cut_hollow_sphere
            lens
            egg
            round_cone
            solid_angle
            dented_sphere
            barth_sextic
            barth_decic
            capped_torus
            link
            chain
            torus_knot
            helix
            thread
            rounded_cylinder
            pipe
            elliptic_cylinder
            heart
            spheres
            formula;
        polyhedron "Polyhedra":
            tetrahedron
            octahedron
            dodecahedron
            icosahedron
            cuboctahedron
            truncated_octahedron
            truncated_icosahedron
            rhombic_dodecahedron
            bipyramid
            prism
            antiprism
            pyramid
            frustum
            hull
            planes;
        planar "Shapes of the plane":
            circle
            ellipse
            rectangle
            rounded_rectangle
            chamfered_rectangle
            rhombus
            trapezoid
            parallelogram
            triangle
            regular_polygon
            polygon
            star
            cross
            pie
            arc_2d
            ring
            horseshoe
            vesica
            moon
            egg_2d
            heart_2d
            parabola
            spiral
            stroke
            stadium
            cut_disk
            tunnel
            stairs
            gear
            superellipse
            text
            svg
            image;
        lift "Solids of shapes of the plane":
            extrude
            revolve
            lathe
            sweep;
        periodic "Periodic surfaces and lattices":
            gyroid
            schwarz_p
            schwarz_d
            lidinoid
            neovius
            i_wp
            f_rd
            split_p
            fischer_koch_s
            cubic
            bcc
            fcc
            octet
            kelvin
            diamond
            rhombic
            fluorite
            isotruss
            honeycomb;
        curve "Tubes along curves":
            polyline
            bezier
            b_spline
            catmull_rom;
        soft "Soft objects":
            metaballs
            blobby
            convolution;
        import "Objects from files":
            mesh
            vdb
            points
            height_field;
        combine "Set operations and blends":
            union
            intersection
            difference
            blend
            morph
            symmetric_difference
            complement
            smooth_union
            smooth_intersection
            smooth_difference
            round_union
            round_intersection
            round_difference
            chamfer_union
            chamfer_intersection
            chamfer_difference
            stairs_union
            stairs_intersection
            stairs_difference
            columns_union
            columns_intersection
            columns_difference
            seam_pipe
            engrave
            groove
            tongue
            clearance;
        structure "Structures":
            slabs
            threads
            pores
            foam
            open_foam
            facet;
    }

    /// What can be done to a shape, in the order of work whatever the order of the text.
    MODIFIERS: Spec = {
        level "Levels":
            isovalue;
        cut "Cuts":
            bounds;
        copies "Copies":
            at
            array
            polar
            hexagonal
            along
            places
            scatter;
        space "Bends of space":
            elongate
            mirror
            shear
            taper
            twist
            bend
            bend_along
            swirl
            wrap_cylinder
            wrap_sphere
            warp
            warp_noise
            remap
            rotate_about
            quaternion
            look_at;
        surface "Offsets, walls and edges":
            round
            fillet
            offset
            onion
            shell
            fill
            displace;
    }

    /// What else can be done to a shape in a list of its own order. Beside a shape these keys are one placement.
    PLACERS: Spec = {
        place "Placement":
            scale
            rotate
            translate;
    }

    /// Where a colour written as a table can come from.
    COLOURS: Source<3> = {
        color "Colours":
            linear
            hsv
            palette
            range
            checker
            noise
            gradient_noise
            simplex
            fbm
            ridged
            turbulence
            worley
            radius
            angle
            waves
            stripes
            wood
            marble
            curvature
            facing
            ramp
            bands
            parts
            conformal
            vdb;
    }

    /// Where a scalar written as a table can come from.
    SCALARS: Source<1> = {
        number "Numbers":
            values
            range
            noise
            gradient_noise
            simplex
            fbm
            ridged
            turbulence
            worley
            radius
            angle
            waves
            stripes
            wood
            marble
            curvature
            facing
            travel
            diffusion
            ramp
            bands
            parts
            interior
            conformal
            material
            vdb;
    }

    /// How a morph's shape changes: the first where a scene says nothing.
    MODES: ModeSpec = {
        mode "Modes of a morph":
            volume
            paper
            linear
            union
            still
            openvdb;
    }
}
