//! Reports of runs: JSON and HTML files.

pub mod arithmetic;
pub mod backends;
pub mod both_ways;
pub mod chart;
pub mod comparison;
pub mod error;
pub mod file;
pub mod file_difference;
pub mod html;
pub mod picture;
pub mod reference;
pub mod values;
pub mod versions;
pub mod whole_file;
