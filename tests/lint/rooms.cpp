#include "tests/lint/rooms.h"

#include "tests/lint/text.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string_view>

namespace zoned::lint {

namespace {

/// Where a room includes another, for the first time.
struct Arrow {
    std::string path;
    int line = 0;
};

/// The rooms of one folder and their arrows, by name of the room that includes and the included.
using Arrows = std::map<std::string, std::map<std::string, Arrow>>;

/// Whether `path` lies in the folder or the room `place`, which may be a file without its ending.
bool lies_in(std::string_view path, std::string_view place) {
    return path.starts_with(place) && path.size() > place.size() &&
           (path[place.size()] == '/' ||
            (path[place.size()] == '.' && path.find('/', place.size()) == std::string_view::npos));
}

/// The folder of the layer table that holds a path: the longest one.
std::string_view layer_folder(std::string_view path) {
    std::string_view found;
    for (const Layer& layer : kLayers) {
        if (lies_in(path, layer.folder) && layer.folder.size() > found.size()) {
            found = layer.folder;
        }
    }
    return found;
}

/// The room of a file, as a path from `folder`; empty: it lies in the folder itself.
std::string room_of(std::string_view path, std::string_view folder) {
    return std::string(folder_of(path.substr(folder.size() + 1)));
}

/// Whether a room is the other one, or the other one lies in it.
bool holds(std::string_view room, std::string_view other) {
    return other.starts_with(room) && (other.size() == room.size() || other[room.size()] == '/');
}

std::map<std::string_view, Arrows> arrows_of(const std::vector<SourceFile>& files) {
    std::map<std::string_view, Arrows> all;
    for (const SourceFile& file : files) {
        const std::string_view folder = layer_folder(file.path);
        if (!is_product(file.path) || folder.empty()) {
            continue;
        }
        const std::string from = room_of(file.path, folder);
        for (const Include& include : includes_of(file.text)) {
            if (!include.quoted || layer_folder(include.target) != folder) {
                continue;
            }
            const std::string to = room_of(include.target, folder);
            if (!to.empty() && !from.empty() && !holds(from, to) && !holds(to, from)) {
                all[folder][from].try_emplace(to, Arrow{file.path, include.line});
            }
        }
    }
    return all;
}

/// The shortest way from a room back to it, as the rooms in between with the room at both ends;
/// empty: there is none.
std::vector<std::string> shortest_cycle(const Arrows& arrows, const std::string& room) {
    std::map<std::string, std::string> before;
    std::deque<std::string> open{room};
    while (!open.empty()) {
        const std::string from = open.front();
        open.pop_front();
        const auto at = arrows.find(from);
        if (at == arrows.end()) {
            continue;
        }
        for (const auto& [to, arrow] : at->second) {
            if (!before.try_emplace(to, from).second) {
                continue;
            }
            if (to != room) {
                open.push_back(to);
                continue;
            }
            std::vector<std::string> cycle{room};
            for (std::string step = from; step != room; step = before.at(step)) {
                cycle.push_back(step);
            }
            cycle.push_back(room);
            std::reverse(cycle.begin(), cycle.end());
            return cycle;
        }
    }
    return {};
}

Finding finding_of(std::string_view folder,
                   const Arrows& arrows,
                   const std::vector<std::string>& cycle) {
    Finding finding{std::string(folder), 0, "rooms include each other in a circle: " + cycle[0]};
    for (std::size_t i = 1; i < cycle.size(); ++i) {
        const Arrow& arrow = arrows.at(cycle[i - 1]).at(cycle[i]);
        finding.what +=
            " -> " + cycle[i] + " (" + arrow.path + ":" + std::to_string(arrow.line) + ")";
    }
    return finding;
}

/// The place of a file in an order; none: it lies in no room of it.
std::optional<std::size_t> place_in(const RoomOrder& order, std::string_view path) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < order.rooms.size(); ++i) {
        const bool longer = !found || order.rooms[i].size() > order.rooms[*found].size();
        if (longer && lies_in(path.substr(order.folder.size() + 1), order.rooms[i])) {
            found = i;
        }
    }
    return found;
}

void check_file_order(const SourceFile& file,
                      const RoomOrder& order,
                      std::vector<Finding>& findings) {
    const std::optional<std::size_t> place = place_in(order, file.path);
    if (!place) {
        findings.push_back(
            {file.path, 0, "lies in no room of the order of " + std::string(order.folder)});
        return;
    }
    for (const Include& include : includes_of(file.text)) {
        if (!include.quoted || !lies_in(include.target, order.folder)) {
            continue;
        }
        const std::optional<std::size_t> target = place_in(order, include.target);
        if (target && *target > *place) {
            findings.push_back({file.path,
                                include.line,
                                std::string(order.rooms[*place]) + " includes \"" +
                                    std::string(include.target) + "\", and " +
                                    std::string(order.rooms[*target]) +
                                    " stands after it in the order of its rooms"});
        }
    }
}

}  // namespace

std::vector<Finding> check_layer_table(const std::vector<SourceFile>& files) {
    std::vector<Finding> findings;
    for (const Layer& layer : kLayers) {
        const bool exists = std::any_of(files.begin(), files.end(), [&](const SourceFile& file) {
            return lies_in(file.path, layer.folder);
        });
        if (!exists) {
            findings.push_back(
                {std::string(layer.folder), 0, "stands in the layer table and does not exist"});
        }
    }
    return findings;
}

std::vector<Finding> check_folder_sizes(const std::vector<SourceFile>& files,
                                        std::span<const LargeFolder> exceptions) {
    std::map<std::string_view, int> sizes;
    for (const SourceFile& file : files) {
        if (is_product(file.path)) {
            ++sizes[folder_of(file.path)];
        }
    }
    std::vector<Finding> findings;
    for (const auto& [folder, size] : sizes) {
        const auto excepted =
            std::find_if(exceptions.begin(), exceptions.end(), [&](const LargeFolder& e) {
                return e.folder == folder;
            });
        const int most = excepted == exceptions.end() ? kMostInFolder : excepted->most;
        if (size > most) {
            findings.push_back({std::string(folder),
                                0,
                                "holds " + std::to_string(size) + " headers and sources, " +
                                    std::to_string(most) + " are allowed"});
        }
        if (excepted != exceptions.end() && size <= kMostInFolder) {
            findings.push_back({std::string(folder), 0, "needs no exception for its size"});
        }
    }
    return findings;
}

std::vector<Finding> check_room_cycles(const std::vector<SourceFile>& files) {
    std::vector<Finding> findings;
    for (const auto& [folder, arrows] : arrows_of(files)) {
        std::set<std::string> told;
        for (const auto& [room, targets] : arrows) {
            const std::vector<std::string> cycle = shortest_cycle(arrows, room);
            if (cycle.empty() || told.contains(room)) {
                continue;
            }
            told.insert(cycle.begin(), cycle.end());
            findings.push_back(finding_of(folder, arrows, cycle));
        }
    }
    return findings;
}

std::vector<Finding> check_room_order(const std::vector<SourceFile>& files,
                                      std::span<const RoomOrder> orders) {
    std::vector<Finding> findings;
    for (const SourceFile& file : files) {
        for (const RoomOrder& order : orders) {
            if (is_product(file.path) && lies_in(file.path, order.folder)) {
                check_file_order(file, order, findings);
            }
        }
    }
    return findings;
}

}  // namespace zoned::lint
