//! Measures the peak rates of one core for rooflines (`profiling/roofline`): instructions per second, and
//! bytes per second from each level of memory.
//!
//! The number of instructions is that of a build with AVX2 or more. Other builds need several instructions
//! for an operation on a vector.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use wide::f32x8;

/// Independent vectors, each with one multiplication and one addition per step.
const VECTORS: usize = 12;
/// Independent chains of integers, each with three rotations and three additions per step.
const INTEGERS: usize = 4;
const STEPS: u64 = 1000;
/// Instructions per step.
const INSTRUCTIONS: u64 = (2 * VECTORS + 6 * INTEGERS) as u64;

/// A mix that keeps all execution units of a core busy. The dependent operations of a step take 6
/// to 8 cycles for a vector and 6 for a chain of integers.
#[inline(never)]
fn mixed(vectors: &mut [f32x8; VECTORS], integers: &mut [u64; INTEGERS]) {
    let (mut v, mut i) = (*vectors, *integers);
    let (factor, addend) = (f32x8::splat(0.999), f32x8::splat(0.001));
    for _ in 0..STEPS {
        for vector in &mut v {
            *vector = *vector * factor + addend;
        }
        for integer in &mut i {
            for _ in 0..3 {
                *integer = integer.rotate_left(7).wrapping_add(STEPS);
            }
        }
    }
    (*vectors, *integers) = (v, i);
}

fn instructions(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("peak");
    group.throughput(Throughput::Elements(STEPS * INSTRUCTIONS));
    let (mut vectors, mut integers) = ([f32x8::splat(1.0); VECTORS], [1; INTEGERS]);
    group.bench_function("instructions", |bencher| {
        bencher.iter(|| mixed(black_box(&mut vectors), black_box(&mut integers)));
    });
    group.finish();
}

/// Adds all numbers with eight independent vector sums.
#[inline(never)]
fn sum(numbers: &[f32]) -> f32 {
    let mut sums = [f32x8::ZERO; 8];
    for chunk in numbers.chunks_exact(64) {
        for (sum, part) in sums.iter_mut().zip(chunk.chunks_exact(8)) {
            *sum += f32x8::new(part.try_into().expect("chunks of eight"));
        }
    }
    sums.into_iter().fold(f32x8::ZERO, |all, sum| all + sum).reduce_add()
}

fn memory(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("peak");
    for kib in [16, 512, 8 << 10, 256 << 10] {
        let numbers = vec![1.0; kib * 256];
        group.throughput(Throughput::Bytes(kib as u64 * 1024));
        group.bench_with_input(BenchmarkId::new("read-KiB", kib), &numbers, |bencher, numbers| {
            bencher.iter(|| sum(black_box(numbers)));
        });
    }
    group.finish();
}

criterion_group!(benches, instructions, memory);
criterion_main!(benches);
