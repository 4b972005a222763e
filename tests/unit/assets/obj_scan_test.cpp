// The OBJ reader: the statements it takes, and how it names mistakes.
#include "server/assets/obj_scan.h"

#include <gtest/gtest.h>

namespace zoned::assets {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 0 1\n";

/// "LINE: text" of the only mistake.
std::string only_mistake(const std::string& text) {
    const ObjScan scan = scan_obj(text);
    EXPECT_EQ(scan.mistake_count, 1U);
    return scan.mistakes.empty()
               ? std::string()
               : std::to_string(scan.mistakes[0].line) + ": " + scan.mistakes[0].text;
}

TEST(ObjScan, ReadsEveryWayToWriteNumbersAndCorners) {
    const ObjScan scan = scan_obj(
        "# a comment\r\n\r\n  v\t+1 -.5 2.\r"
        "v 1e-3 2E+2 0.1 1.0\nv 0 0 0 0.5 0.5 0.5\nvt 0 0\nvn 0 1 0\nusemtl red\ns off\n"
        "f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf -3/1/1 -2/1/1 +3/1/1\nl 1 2\np 3\nf 1 2 3 4\n"
        "v 0.999 -200.5 1.9");
    EXPECT_TRUE(scan.good()) << scan.mistakes[0].line << ": " << scan.mistakes[0].text;
    ASSERT_EQ(scan.vertices.size(), 4U);
    EXPECT_EQ(scan.vertices[0], Vec3(1.0F, -0.5F, 2.0F));
    EXPECT_EQ(scan.vertices[1], Vec3(0.001F, 200.0F, 0.1F));
    EXPECT_EQ(scan.vertex_lines, (std::vector<std::uint32_t>{3, 4, 5, 17}));
    EXPECT_EQ(scan.faces, 5U);
    EXPECT_EQ(scan.indices,
              (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(scan.triangle_lines, (std::vector<std::uint32_t>{10, 11, 12, 13, 16, 16}));
}

TEST(ObjScan, NamesLineAndReasonOfEachMistake) {
    const std::pair<const char*, const char*> mistakes[] = {
        {"v 1 x 0", "4: 'x' is no finite number"},
        {"v 1 nan 0", "4: 'nan' is no finite number"},
        {"v 1 1e39 0", "4: '1e39' is no finite number"},
        {"v 1 2,5 0", "4: '2,5' is no finite number"},
        {"v 1 +-2 0", "4: '+-2' is no finite number"},
        {"v 1 2", "4: a vertex has three coordinates; here are 2"},
        {"v", "4: a vertex has three coordinates; here are 0"},
        {"f 1 2", "4: a face has three corners or more; here are 2"},
        {"f 1 2 4", "4: names vertex 4 of 3"},
        {"f 1 2 -4", "4: names vertex -4 where there are 3 so far"},
        {"f 0 1 2", "4: '0' is no corner: i, i/j, i//k or i/j/k, none of them zero"},
        {"f 1/ 2 3", "4: '1/' is no corner: i, i/j, i//k or i/j/k, none of them zero"},
        {"f 1 2 3.5", "4: '3.5' is no corner: i, i/j, i//k or i/j/k, none of them zero"},
        {"f 1/1/1/1 2 3", "4: '1/1/1/1' is no corner: i, i/j, i//k or i/j/k, none of them zero"},
        {"l 1 7", "4: names vertex 7 of 3"},
        {"f 1 2 \\", "4: goes on in the next line: lines joined by a backslash are not read"},
        {"face 1 2 3", "4: 'face' is no word of the OBJ format"},
        {"curv2 1 2", "4: 'curv2' is of a free-form surface; only polygons are read"},
    };
    for (const auto& [line, mistake] : mistakes) {
        EXPECT_EQ(only_mistake(kTriangle + line + "\nf 1 2 3\n"), mistake);
    }
    EXPECT_EQ(only_mistake(std::string("v 0 0 0\nv 0 0 \0", 15)),
              "2: holds a zero byte: this is no text");
    EXPECT_EQ(only_mistake("v 0 0 0\nv 1 0 1\nv 1 0 0\nv 0 0 1.5\nf 1 2 3 4\n"),
              "5: the outline of the face crosses itself");
    std::string polygon = "f";
    for (std::size_t i = 0; i <= kMaxObjCorners; ++i) {
        polygon += " 1";
    }
    EXPECT_EQ(only_mistake(kTriangle + polygon),
              "4: a face of 257 corners; at most 256: cut it into smaller ones");
}

TEST(ObjScan, TellsAllMistakesInOrderAndCountsThoseBeyondTheLimit) {
    const ObjScan scan = scan_obj("f 1 2 9\nv 0 0\nv x\nhello\n" + kTriangle);
    ASSERT_EQ(scan.mistakes.size(), 4U);
    for (std::uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(scan.mistakes[i].line, i + 1);
    }
    std::string many;
    for (std::size_t i = 0; i < 3 * kMaxObjMistakes; ++i) {
        many += "what?\n";
    }
    EXPECT_EQ(scan_obj(many).mistake_count, 3 * kMaxObjMistakes);
    EXPECT_EQ(scan_obj(many).mistakes.size(), kMaxObjMistakes);
}

}  // namespace
}  // namespace zoned::assets
