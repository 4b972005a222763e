#include "tests/bench/picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace zoned::bench {

namespace {

constexpr double kPixelsWide = 720.0;

template <class... Values>
std::string shape(const char* format, Values... values) {
    char text[400];
    const int size = std::snprintf(text, sizeof(text), format, values...);
    return {text, static_cast<std::size_t>(std::clamp(size, 0, 399))};
}

}  // namespace

Picture::Picture(double x0, double z0, double width, double height)
    : x0_(x0),
      z0_(z0),
      width_(width),
      height_(height) {
}

void Picture::box(double x, double z, double width, double height, const std::string& colour) {
    shapes_ += shape("<rect x=\"%.3f\" y=\"%.3f\" width=\"%.3f\" height=\"%.3f\" fill=\"%s\"/>\n",
                     x,
                     z,
                     width,
                     height,
                     colour.c_str());
}

void Picture::line(double ax,
                   double az,
                   double bx,
                   double bz,
                   double thickness,
                   const std::string& colour) {
    shapes_ += shape(
        "<line x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" y2=\"%.3f\" stroke=\"%s\" stroke-width=\"%.3f\" "
        "stroke-linecap=\"round\"/>\n",
        ax,
        az,
        bx,
        bz,
        colour.c_str(),
        thickness);
}

void Picture::disc(double x, double z, double radius, const std::string& colour) {
    shapes_ += shape(
        "<circle cx=\"%.3f\" cy=\"%.3f\" r=\"%.3f\" fill=\"%s\"/>\n", x, z, radius, colour.c_str());
}

void Picture::arrow(double ax,
                    double az,
                    double bx,
                    double bz,
                    double thickness,
                    const std::string& colour) {
    line(ax, az, bx, bz, thickness, colour);
    const double dx = (bx - ax) / 3.0;
    const double dz = (bz - az) / 3.0;
    line(bx, bz, bx - dx - 0.6 * dz, bz - dz + 0.6 * dx, thickness, colour);
    line(bx, bz, bx - dx + 0.6 * dz, bz - dz - 0.6 * dx, thickness, colour);
}

std::string Picture::svg() const {
    return shape(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
               "viewBox=\"%.3f %.3f %.3f %.3f\">\n",
               kPixelsWide,
               kPixelsWide * height_ / width_,
               x0_,
               z0_,
               width_,
               height_) +
           shapes_ + "</svg>\n";
}

std::string shade(double share, int hue) {
    const double s = std::clamp(share, 0.0, 1.0);
    return shape("hsl(%d,80%%,%.1f%%)", hue, 100.0 - 60.0 * s);
}

std::string colour_of_direction(double x, double z) {
    const double turn = std::atan2(z, x) / (2.0 * std::numbers::pi);
    return shape("hsl(%.0f,70%%,45%%)", 360.0 * (turn < 0.0 ? turn + 1.0 : turn));
}

}  // namespace zoned::bench
