//! sdp3-core
#![no_std]
