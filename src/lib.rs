//! orogen: procedural solids from scripts.
//!
//! A solid is a function of space, negative inside, zero on its surface and positive outside. A
//! [Rhai](https://rhai.rs) script builds such a function out of shapes, noises and operations, as an
//! expression graph:
//!
//! ```text
//! script --> expr::Graph --> tape::Tape --> cast::Caster --> render::Picture
//! text       hash-consed     straight-line   first hits       light and air
//! ```
//!
//! Each operation states its meaning once ([`op`]): value, derivatives, range, linear form. Each
//! kind of number ([`num`]) lifts every operation by one rule: to points, gradients, Hessians,
//! intervals, affine forms, batches. So the same expression answers "what is the value here", "can it
//! be zero in this box" and "how steep is it at most", and an answer about a region is a proof.
//!
//! ```
//! use orogen::field::Field;
//! use orogen::num::Interval;
//! use orogen::script::{Request, compile};
//!
//! let compiled = compile(&Request::text("sphere(1.0) + 0.3 * gradient(7).scaled(4.0)"));
//! let scene = compiled.scene.expect("the script is right");
//! let mut rock = Field::new(&scene.graph, scene.surface.field);
//!
//! // Far outside, and proven to be outside over a whole box.
//! assert!(rock.value([2.0, 0.0, 0.0].into()) > 0.6);
//! let far = [Interval::new(1.5, 2.5), Interval::radius(0.5), Interval::radius(0.5)];
//! assert!(rock.range(&far).lo > 0.0);
//!
//! // One sphere and one octave: no steeper than 1 + 0.3 * 4 * 3.75 anywhere.
//! let around = [Interval::radius(1.5); 3];
//! assert!(rock.lipschitz(&around) < 6.3);
//! ```
//!
//! Pictures, meshes, components and maps of whole scenes are made by [`session`]; what it calls is there too, for parts of
//! that. Finished parts of an analysis of components, and grids that take long, are kept in a [folder](world::store) of the
//! user's, `OROGEN_CACHE` if that is set, or nowhere if it is `off`.
//!
//! `examples/` has whole programs: a script to a picture and a mesh (`render.rs`), a scene built in Rust
//! (`planet.rs`), the proof of the constants of gradient noise (`certify_noise.rs`).
//!
//! A module uses only modules of rows above its own:
//!
//! | module | holds |
//! |---|---|
//! | [`num`] [`diag`] | numbers and how functions are lifted to them; diagnostics |
//! | [`op`] [`noise`] [`grid`] [`shape`] [`flow`] [`world`] | operations; noises and fractals; sampled fields; shapes made of data; fields carried along by velocities; files |
//! | [`expr`] [`exchange`] | expression graphs; files of other programs |
//! | [`tape`] [`scene`] | straight-line code; scenes as plain data |
//! | [`field`] | values, derivatives and bounds of an expression |
//! | [`script`] [`cast`] [`topology`] [`mesh`] [`analysis`] | the script host; ray casters; components of solids; meshes of solids; statistics and spectra of noises |
//! | [`render`] | pictures |
//! | [`session`] | scripts to pictures, meshes, components, grids and maps of heights, with cancellation and caching |
//! | [`cli`] | the commands |

// Module documentation is for readers of the source too, who can follow links to private items.
#![allow(rustdoc::private_intra_doc_links)]
// What tests make of random numbers need not be the same on every platform.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod analysis;
pub mod cast;
pub mod cli;
pub mod diag;
pub mod exchange;
pub mod expr;
pub mod field;
pub mod flow;
pub mod grid;
pub mod mesh;
pub mod noise;
pub mod num;
pub mod op;
pub mod render;
pub mod scene;
pub mod script;
pub mod session;
pub mod shape;
pub mod tape;
pub mod topology;
pub mod world;
