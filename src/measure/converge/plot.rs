//! Plots the error over samples next to the error over seconds, on logarithmic axes.

use std::ops::Range;

use plotters::prelude::*;

use super::{Curve, Point, Slope};
use crate::error::{Error, Result};

/// Draws `curves` as an SVG document.
///
/// # Errors
/// [`Error::Internal`] if the plot cannot be drawn.
pub(crate) fn plot(title: &str, curves: &[Curve]) -> Result<String> {
    let mut svg = String::new();
    match draw(&mut svg, title, curves) {
        Ok(()) => {}
        Err(error) => return Err(Error::Internal(format!("cannot draw the plot: {error}"))),
    }
    Ok(svg)
}

fn draw<'a>(
    svg: &'a mut String,
    title: &str,
    curves: &[Curve],
) -> std::result::Result<(), Box<dyn std::error::Error + 'a>> {
    let area = SVGBackend::with_string(svg, (1120, 520)).into_drawing_area();
    area.fill(&WHITE)?;
    let halves = area.titled(title, ("sans-serif", 20))?.split_evenly((1, 2));
    panel(&halves[0], "samples per pixel", curves, |point| f64::from(point.spp))?;
    panel(&halves[1], "seconds", curves, |point| point.seconds)?;
    area.present()?;
    Ok(())
}

/// A palette for people with and without colour blindness (Okabe and Ito).
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

fn panel<'a>(
    area: &DrawingArea<SVGBackend<'a>, plotters::coord::Shift>,
    across: &str,
    curves: &[Curve],
    x: impl Fn(&Point) -> f64,
) -> std::result::Result<(), Box<dyn std::error::Error + 'a>> {
    let points = || curves.iter().flat_map(|curve| &curve.points).filter(|point| point.mse > 0.0);
    let (xs, ys) = (range(points().map(&x)), range(points().map(|point| point.mse)));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d::<LogRange, LogRange>(
        xs.log_scale().into(),
        ys.log_scale().into(),
    )?;
    chart
        .configure_mesh()
        .x_desc(across)
        .y_desc("mean squared error")
        .light_line_style(WHITE)
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()?;
    for (curve, color) in curves.iter().zip(COLORS.into_iter().cycle()) {
        let known = || curve.points.iter().filter(|point| point.mse > 0.0);
        let line =
            LineSeries::new(known().map(|point| (x(point), point.mse)), color.stroke_width(2));
        chart
            .draw_series(line)?
            .label(label(curve))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        chart.draw_series(
            known().map(|point| Circle::new((x(point), point.mse), 3, color.filled())),
        )?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}

/// Label of a curve: the name of its way of rendering, and its slope over samples.
fn label(curve: &Curve) -> String {
    let slope = Slope::of_samples(&curve.points);
    let slope = slope.map_or_else(String::new, |slope| format!(", slope {:.2}", slope.slope));
    curve.way.name() + &slope
}

type LogRange = plotters::coord::combinators::LogCoord<f64>;

/// The range from a little below the smallest value to a little above the largest.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    if low < high { low / 1.3..high * 1.3 } else { 0.1..1.0 }
}
