#include "server/cluster/directory.h"

namespace zoned::cluster {

void Directory::take(const std::string& world, const BoardEntry& entry, double now_s) {
    const std::lock_guard lock(mutex_);
    KnownWorld& seen = seen_[world];
    if (entry.revision <= seen.revision) {
        return;  // an answer that is older than the one before
    }
    seen.revision = entry.revision;
    seen.changed_s = now_s;
    if (!seen.entry.ParseFromString(entry.value)) {
        seen.entry.Clear();
    }
}

std::string Directory::list(double now_s) {
    const auto listed = board_.list("world");
    if (!listed.ok()) {
        return listed.error().text;
    }
    for (const auto& [key, entry] : *listed) {
        take(key.substr(key.find('.') + 1), entry, now_s);
    }
    return {};
}

std::string Directory::look(double now_s) {
    std::vector<std::string> names;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& [name, seen] : seen_) {
            names.push_back(name);
        }
    }
    for (const std::string& name : names) {
        const auto found = board_.get("world." + name);
        if (!found.ok()) {
            return found.error().text;
        }
        if (*found) {
            take(name, **found, now_s);
        }
    }
    return {};
}

void Directory::know(const std::string& world) {
    const std::lock_guard lock(mutex_);
    seen_.try_emplace(world);
}

std::optional<ListedWorld> Directory::find(const std::string& world, double now_s) const {
    const std::lock_guard lock(mutex_);
    const auto it = seen_.find(world);
    if (it == seen_.end() || it->second.revision == 0) {
        return std::nullopt;
    }
    return ListedWorld{it->second.entry, it->second.revision, now_s - it->second.changed_s};
}

std::vector<ListedWorld> Directory::all(double now_s) const {
    const std::lock_guard lock(mutex_);
    std::vector<ListedWorld> out;
    for (const auto& [name, seen] : seen_) {
        if (seen.revision != 0) {
            out.push_back({seen.entry, seen.revision, now_s - seen.changed_s});
        }
    }
    return out;
}

}  // namespace zoned::cluster
