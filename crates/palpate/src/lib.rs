#![no_std]
#![doc = include_str!("../README.md")]

pub use palpate_core::*;

#[cfg(feature = "rt")]
#[doc(inline)]
pub use palpate_device as device;
#[cfg(feature = "record")]
#[doc(inline)]
pub use palpate_record as record;
#[cfg(feature = "rt")]
#[doc(inline)]
pub use palpate_rt as rt;
#[cfg(feature = "scene")]
#[doc(inline)]
pub use palpate_scene as scene;
#[cfg(feature = "study")]
#[doc(inline)]
pub use palpate_study as study;
#[cfg(feature = "study")]
#[doc(inline)]
pub use palpate_testbed as testbed;
#[cfg(feature = "world")]
#[doc(inline)]
pub use palpate_world as world;

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct RepositoryReadmeExamples;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/signs.md")]
struct SignsExamples;
