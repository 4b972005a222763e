// Picture: a scene seen from above, as SVG.
#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace zoned::bench {

/// Lengths are metres, x to the right and z downwards; parts outside the view are cut off.
class Picture {
  public:
    /// A view from (x0, z0), `width` x `height` m, both > 0.
    Picture(double x0, double z0, double width, double height);

    /// `colour` as in CSS.
    void box(double x, double z, double width, double height, const std::string& colour);
    void line(double ax,
              double az,
              double bx,
              double bz,
              double thickness,
              const std::string& colour);
    void disc(double x, double z, double radius, const std::string& colour);
    /// An arrow from one place to another, with a head a third as long.
    void arrow(double ax,
               double az,
               double bx,
               double bz,
               double thickness,
               const std::string& colour);

    [[nodiscard]] std::string svg() const;

  private:
    double x0_, z0_, width_, height_;
    std::string shapes_;
};

/// A colour for a share from 0 (white) to 1, of the hue 0 to 360.
std::string shade(double share, int hue);

/// A colour for a direction.
std::string colour_of_direction(double x, double z);

}  // namespace zoned::bench
