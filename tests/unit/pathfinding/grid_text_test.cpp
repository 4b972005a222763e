#include "tests/scenario/grid_text.h"

#include <gmock/gmock.h>

namespace zoned::ai::pathfinding {

using namespace scenario;

namespace {

using ::testing::HasSubstr;

TEST(GridText, ReadsTerrainAsPassableOrNot) {
    const auto map =
        parse_grid_map("type octile\r\nheight 2\r\nwidth 4\r\nmap\r\n.GS@\r\nOTW.\r\n");
    ASSERT_TRUE(map) << map.error();
    ASSERT_EQ(map->width(), 4);
    ASSERT_EQ(map->height(), 2);
    EXPECT_EQ(map->passable_cells(), 4U);
    for (const Cell c : {Cell{0, 0}, Cell{1, 0}, Cell{2, 0}, Cell{3, 1}}) {
        EXPECT_TRUE(map->passable(c)) << c.x << ", " << c.y;
    }
    EXPECT_FALSE(map->passable(Cell{3, 0}));
    EXPECT_FALSE(map->passable(Cell{4, 0})) << "off the map";
    EXPECT_FALSE(map->passable(Cell{0, 2})) << "off the map";
}

struct Malformed {
    const char* text;
    const char* place;
    const char* reason;
};

TEST(GridText, RefusesMalformedMapsWithLineAndReason) {
    const Malformed cases[] = {
        {"", "line 1", "'type'"},
        {"type tile\n", "line 1", "'octile'"},
        {"type octile\nwidth 3\n", "line 2", "'height'"},
        {"type octile\nheight three\n", "line 2", "'three'"},
        {"type octile\nheight 0\nwidth 1\nmap\n", "line 2", "from 1 to"},
        {"type octile\nheight 99999999999999999999\n", "line 2", "whole number"},
        {"type octile\nheight 9000\n", "line 2", "to 8192"},
        {"type octile\nheight 2 3\n", "line 2", "too much"},
        {"type octile\nheight 2\nwidth 2\nrows\n", "line 4", "'map'"},
        {"type octile\nheight 2\nwidth 2\nmap\n..\n", "line 5", "after 1 of 2"},
        {"type octile\nheight 2\nwidth 2\nmap\n..\n...\n", "line 6", "3 characters"},
        {"type octile\nheight 2\nwidth 2\nmap\n..\n.x\n", "line 6", "column 2"},
        {"type octile\nheight 1\nwidth 2\nmap\n..\n..\n", "line 6", "below the last row"}};
    for (const Malformed& m : cases) {
        const auto map = parse_grid_map(m.text);
        ASSERT_FALSE(map) << m.text;
        EXPECT_THAT(map.error(), HasSubstr(m.place)) << m.text;
        EXPECT_THAT(map.error(), HasSubstr(m.reason)) << m.text;
    }
}

TEST(GridText, RefusesMapsWhoseWaysMayBeTooLong) {
    std::string text = "type octile\nheight 2000\nwidth 1501\nmap\n";
    std::string row(1501, '.');
    row += '\n';
    for (int y = 0; y < 2000; ++y) {
        text += row;
    }
    const auto map = parse_grid_map(text);
    ASSERT_FALSE(map);
    EXPECT_THAT(map.error(), HasSubstr("3002000 passable cells"));
}

TEST(GridText, ReadsScenariosBetweenTabsOrSpaces) {
    const auto found =
        parse_grid_scenario("version 1.0\n0\ta b.map\t9\t8\t1\t2\t3\t4\t2.82843\r\n");
    EXPECT_FALSE(found) << "a space in a name shifts all fields";
    const auto read = parse_grid_scenario(
        "version 1\n0\tm.map\t9\t8\t1\t2\t3\t4\t2.82843\r\n\n33 maps/m.map 9 8 8 7 0 0 10.4\n");
    ASSERT_TRUE(read) << read.error();
    ASSERT_EQ(read->size(), 2U);
    EXPECT_EQ((*read)[0].start, (Cell{1, 2}));
    EXPECT_EQ((*read)[0].goal, (Cell{3, 4}));
    EXPECT_EQ((*read)[0].length, 2.82843);
    EXPECT_EQ((*read)[0].line, 2);
    EXPECT_EQ((*read)[1].start, (Cell{8, 7}));
    EXPECT_EQ((*read)[1].line, 4);
}

TEST(GridText, RefusesMalformedScenariosWithLineAndReason) {
    const Malformed cases[] = {{"", "line 1", "empty"},
                               {"version 3\n", "line 1", "only 1"},
                               {"version 1\n0 m 9 8 9 2 3 4 1\n", "line 2", "start x is '9'"},
                               {"version 1\n0 m 9 8 1 2 3 -4 1\n", "line 2", "goal y is '-4'"},
                               {"version 1\n0 m 9 8 1 2 3 4\n", "line 2", "length is ''"},
                               {"version 1\n0 m 9 8 1 2 3 4 nan\n", "line 2", "length is 'nan'"},
                               {"version 1\n0 m 9 8 1 2 3 4 inf\n", "line 2", "length is 'inf'"},
                               {"version 1\n0 m 9 8 1 2 3 4 5 6\n", "line 2", "'6' is too much"}};
    for (const Malformed& m : cases) {
        const auto found = parse_grid_scenario(m.text);
        ASSERT_FALSE(found) << m.text;
        EXPECT_THAT(found.error(), HasSubstr(m.place)) << m.text;
        EXPECT_THAT(found.error(), HasSubstr(m.reason)) << m.text;
    }
}

TEST(GridText, ReadsPatchesAndEventsOfMapsThatChange) {
    const auto patches = parse_grid_patches(
        "type patch\npatches 2\npatch 0\nheight 1\nwidth 2\nmap\n@.\npatch 1\nheight 1\nwidth "
        "1\nmap\n.\n");
    ASSERT_TRUE(patches) << patches.error();
    ASSERT_EQ(patches->size(), 2U);
    EXPECT_EQ((*patches)[0].passable, (std::vector<bool>{false, true}));
    const auto events = parse_grid_events(
        "version 2\nheight 4\nwidth 5\ncost 1 octile\npatch a.patch\ncommands\nQ 0 0 1 4 3 "
        "5.2\nP 0 1 3 2\n");
    ASSERT_TRUE(events) << events.error();
    ASSERT_EQ(events->size(), 2U);
    EXPECT_TRUE((*events)[0].query);
    EXPECT_EQ((*events)[0].instance.goal, (Cell{4, 3}));
    EXPECT_EQ((*events)[1].patch, 1);
    EXPECT_EQ((*events)[1].x, 3);
    const auto order = parse_grid_patches("type patch\npatches 1\npatch 1\n");
    ASSERT_FALSE(order);
    EXPECT_THAT(order.error(), HasSubstr("line 3"));
    const auto neither = parse_grid_events("version 2\nheight 4\nwidth 5\ncommands\nR 0\n");
    ASSERT_FALSE(neither);
    EXPECT_THAT(neither.error(), HasSubstr("line 5"));
    const auto none = parse_grid_events("version 2\nheight 4\nwidth 5\n");
    ASSERT_FALSE(none);
    EXPECT_THAT(none.error(), HasSubstr("'commands'"));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
