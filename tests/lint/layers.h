// The layer order of the source tree as data: a folder may include only what stands above it.
#pragma once

#include <array>
#include <span>
#include <string_view>

namespace zoned::lint {

/// Which programs a folder belongs to.
enum class Side {
    kShared,
    kServer,
    kClient,
};

struct Layer {
    std::string_view folder;
    int row;  ///< may include smaller rows of sides that it may see, and itself; never its siblings
    Side side;
};

/// Rows up to this one know no asio, spdlog, protobuf, wall clock or threads: they replay bit for
/// bit.
inline constexpr int kLastPureRow = 9;

/// No row is farther down.
inline constexpr int kLastRow = 100;

/// proto stands between the zone and the folders of row 10, which all may read it.
inline constexpr int kProtoRow = 10;

inline constexpr std::array kLayers{
    Layer{"shared/core", 1, Side::kShared},
    Layer{"shared/math", 2, Side::kShared},
    Layer{"shared/clock", 2, Side::kShared},
    Layer{"shared/motion", 3, Side::kShared},
    Layer{"shared/wire", 4, Side::kShared},
    Layer{"kernels/include", 5, Side::kServer},
    Layer{"server/compute", 6, Side::kServer},
    Layer{"server/spatial", 6, Side::kServer},
    Layer{"server/mailbox", 6, Side::kServer},
    Layer{"server/world", 7, Side::kServer},
    Layer{"server/physics", 8, Side::kServer},
    Layer{"server/ai", 8, Side::kServer},
    Layer{"server/interest", 8, Side::kServer},
    Layer{"server/replication", 8, Side::kServer},
    Layer{"server/zone", 9, Side::kServer},
    Layer{"proto", kProtoRow, Side::kShared},
    Layer{"server/assets", 11, Side::kServer},
    Layer{"server/recording", 11, Side::kServer},
    Layer{"server/store", 11, Side::kServer},
    Layer{"server/config", 12, Side::kServer},
    Layer{"server/rules", 11, Side::kServer},
    Layer{"server/scripting", 11, Side::kServer},
    Layer{"server/net", 12, Side::kServer},
    Layer{"server/session", 13, Side::kServer},
    Layer{"server/admin", 13, Side::kServer},
    Layer{"server/cluster", 13, Side::kServer},
    Layer{"server/app", 14, Side::kServer},
    Layer{"server", 15, Side::kServer},  // server/main.cpp
    Layer{"client-sim/link", 11, Side::kClient},
    Layer{"client-sim/view", 12, Side::kClient},
    Layer{"client-sim/audit", 13, Side::kClient},
    Layer{"client-sim/library", 14, Side::kClient},
    Layer{"client-sim/web", 15, Side::kClient},
    Layer{"client-sim/bot", 14, Side::kClient},
    Layer{"client-sim/measure", 15, Side::kClient},
    Layer{"client-sim/app", 16, Side::kClient},
    Layer{"client-sim", 17, Side::kClient},  // client-sim/main.cpp
};

/// A sibling that may be asked after all: files of `from` may include files that begin with
/// `prefix`.
struct SiblingException {
    std::string_view from;
    std::string_view prefix;
};

inline constexpr std::array kSiblingExceptions{
    SiblingException{"server/ai", "server/physics/query/"},
};

/// An include that only some places may have. Up to `last_row`, a file may include what begins with
/// `prefix` (as written between the brackets or quotes) only where its path begins with one of
/// `allowed`.
struct RestrictedInclude {
    std::string_view prefix;
    int last_row;
    std::array<std::string_view, 2> allowed;  ///< empty entries allow nothing
};

inline constexpr std::array kRestrictedIncludes{
    RestrictedInclude{"asio", kLastPureRow, {}},
    RestrictedInclude{"spdlog", kLastPureRow, {}},
    RestrictedInclude{"fmt/", kLastPureRow, {}},
    RestrictedInclude{"google/", kLastPureRow, {}},
    RestrictedInclude{"proto/", kLastPureRow, {}},
    RestrictedInclude{"openssl/",
                      kLastPureRow,
                      {"shared/wire/seal.cpp", "shared/wire/websocket/websocket_upgrade.cpp"}},
    RestrictedInclude{"thread", kLastPureRow, {"server/compute/"}},
    RestrictedInclude{"future", kLastPureRow, {"server/compute/"}},
    RestrictedInclude{"condition_variable", kLastPureRow, {"server/compute/"}},
    RestrictedInclude{"mutex", kLastPureRow, {"server/mailbox/", "server/compute/"}},
    RestrictedInclude{"shared_mutex", kLastPureRow, {"server/mailbox/", "server/compute/"}},
    RestrictedInclude{"atomic", kLastPureRow, {"server/mailbox/", "server/compute/"}},
    RestrictedInclude{"chrono", kLastPureRow, {}},
    RestrictedInclude{"ctime",
                      kLastPureRow,
                      {"server/compute/"}},  // CPU time of workers, for reports
    RestrictedInclude{"time.h", kLastPureRow, {}},
    RestrictedInclude{"sys/", kLastPureRow, {"shared/core/containers/zero_pages.h"}},
    RestrictedInclude{"random", kLastPureRow, {}},
    RestrictedInclude{"proto/config/", kLastRow, {"server/config/"}},
};

/// Headers and sources that a folder of the product may hold.
inline constexpr int kMostInFolder = 25;

/// A folder that may hold more, and how many.
struct LargeFolder {
    std::string_view folder;
    int most;
};

inline constexpr std::array<LargeFolder, 0> kLargeFolders{};

/// The rooms of a folder, first those that the others may include. A room is a path from the
/// folder: of a folder in it, or of a file without its ending.
struct RoomOrder {
    std::string_view folder;
    std::span<const std::string_view> rooms;
};

inline constexpr std::array<std::string_view, 15> kAiRooms{"learning",
                                                           "decision",
                                                           "splines",
                                                           "crowd",
                                                           "pathfinding",
                                                           "agent/brain",
                                                           "agent",
                                                           "ai_context",
                                                           "perception",
                                                           "steering",
                                                           "offscreen",
                                                           "update",
                                                           "ai_update",
                                                           "explain",
                                                           "serialization"};

inline constexpr std::array<std::string_view, 15> kPhysicsRooms{"simd",
                                                                "integrator",
                                                                "shapes",
                                                                "settings",
                                                                "narrowphase",
                                                                "bodies",
                                                                "joints",
                                                                "contacts",
                                                                "solver",
                                                                "solver_variants",
                                                                "query",
                                                                "scene",
                                                                "particles",
                                                                "soft",
                                                                "method_selection"};

inline constexpr std::array<std::string_view, 11> kConfigRooms{"server_settings",
                                                               "settings",
                                                               "text",
                                                               "plan",
                                                               "types",
                                                               "check",
                                                               "training",
                                                               "world",
                                                               "groups",
                                                               "npc",
                                                               "expand"};

inline constexpr std::array kRoomOrders{RoomOrder{"server/ai", kAiRooms},
                                        RoomOrder{"server/physics", kPhysicsRooms},
                                        RoomOrder{"server/config", kConfigRooms}};

/// The top level of the repository, besides names that begin with a dot and build folders.
inline constexpr std::array<std::string_view, 10> kTopLevel{
    "CMakeLists.txt",
    "README.md",
    "server",
    "client-sim",
    "proto",
    "shared",
    "kernels",
    "config",
    "tests",
    "docker",
};

/// Folders whose files are checked: the top level without its two files.
inline constexpr std::array<std::string_view, 8> kCheckedFolders{"server",
                                                                 "client-sim",
                                                                 "proto",
                                                                 "shared",
                                                                 "kernels",
                                                                 "config",
                                                                 "tests",
                                                                 "docker"};

}  // namespace zoned::lint
