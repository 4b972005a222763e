#include "tests/bench/picture.h"

#include <gmock/gmock.h>

namespace zoned::bench {

namespace {

using ::testing::HasSubstr;

TEST(Picture, KeepsMetresAndTheView) {
    Picture picture(-1.0, 2.0, 20.0, 10.0);
    picture.box(0.0, 2.5, 1.0, 2.0, "red");
    picture.disc(3.0, 4.0, 0.25, shade(1.0, 120));
    picture.arrow(0.0, 3.0, 3.0, 3.0, 0.1, "black");
    const std::string svg = picture.svg();
    EXPECT_THAT(svg,
                HasSubstr("width=\"720\" height=\"360\" viewBox=\"-1.000 2.000 20.000 10.000\""));
    EXPECT_THAT(
        svg,
        HasSubstr("<rect x=\"0.000\" y=\"2.500\" width=\"1.000\" height=\"2.000\" fill=\"red\"/>"));
    EXPECT_THAT(
        svg,
        HasSubstr("<circle cx=\"3.000\" cy=\"4.000\" r=\"0.250\" fill=\"hsl(120,80%,40.0%)\"/>"));
    // The head: a third of the length back, 0.6 of that to the sides.
    EXPECT_THAT(svg, HasSubstr("x1=\"3.000\" y1=\"3.000\" x2=\"2.000\" y2=\"3.600\""));
    EXPECT_THAT(svg, HasSubstr("x1=\"3.000\" y1=\"3.000\" x2=\"2.000\" y2=\"2.400\""));
}

TEST(Picture, ColoursDirectionsAllAround) {
    EXPECT_EQ(colour_of_direction(1.0, 0.0), "hsl(0,70%,45%)");
    EXPECT_EQ(colour_of_direction(0.0, 1.0), "hsl(90,70%,45%)");
    EXPECT_EQ(colour_of_direction(0.0, -1.0), "hsl(270,70%,45%)");
    EXPECT_EQ(shade(-1.0, 30), "hsl(30,80%,100.0%)");
}

}  // namespace

}  // namespace zoned::bench
