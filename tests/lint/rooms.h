// Rooms: the folders of the product, how many files they hold and which of them may include which.
#pragma once

#include "tests/lint/check.h"
#include "tests/lint/layers.h"

#include <span>
#include <string>
#include <vector>

namespace zoned::lint {

/// The layer table and the product name the same folders: each row of the table holds a source, and
/// each source lies below a row (check_includes() says which does not).
[[nodiscard]] std::vector<Finding> check_layer_table(const std::vector<SourceFile>& files);

/// No folder of the product holds more than kMostInFolder headers and sources, or as many as its
/// exception allows. Files of folders inside it do not count.
[[nodiscard]] std::vector<Finding> check_folder_sizes(
    const std::vector<SourceFile>& files,
    std::span<const LargeFolder> exceptions = kLargeFolders);

/// The rooms of a folder of the layer table are the folders inside it, at any depth. No room
/// includes another that includes it, on whatever detour. Files that lie in the folder itself are
/// in no room: they may stand above and below the rooms (check_room_order() says where). One
/// finding for each knot of rooms.
[[nodiscard]] std::vector<Finding> check_room_cycles(const std::vector<SourceFile>& files);

/// Files of a folder with a written order include only what lies in the same room or stands before
/// it in the order. A room is a path from the folder, of a folder or of a file without its ending;
/// the longest one that fits a file holds it.
[[nodiscard]] std::vector<Finding> check_room_order(
    const std::vector<SourceFile>& files,
    std::span<const RoomOrder> orders = kRoomOrders);

}  // namespace zoned::lint
