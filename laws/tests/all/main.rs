//! All tests of the stock laws that need more than one law, as one program: linking eight takes minutes.

mod adaptive;
mod backends;
mod cases;
mod catalog;
mod choice;
mod conservation;
mod derivatives;
mod differences;
mod far_field;
mod hierarchical;
mod implicit;
mod jumps;
mod kepler;
mod macros;
mod nystrom;
mod orders;
mod origin;
mod pairs;
mod precision;
mod respa;
mod solar_system;
mod stability;
mod subset;
mod sums;
mod turning;
mod wisdom_holman;
