#include "server/admin/spectator_hub.h"

#include <bit>
#include <cstring>

namespace zoned::admin {

namespace {

static_assert(std::endian::native == std::endian::little, "messages are written as they lie");

template <class T>
void put(std::string& out, const T& value) {
    const std::size_t at = out.size();
    out.resize(at + sizeof(T));
    std::memcpy(out.data() + at, &value, sizeof(T));
}

void put_row(std::string& out, const SpectatorRow& row) {
    put(out, row.id);
    put(out, row.position);
    put(out, row.orientation);
    put(out, row.type);
    put(out, row.flags);
    put(out, row.zone);
}

std::string head(std::uint32_t kind, std::int64_t tick, std::size_t removed, std::size_t rows) {
    std::string out;
    out.reserve(SpectatorHub::kHeadBytes + 4 * removed + SpectatorHub::kRowBytes * rows);
    put(out, kind);
    put(out, static_cast<std::uint32_t>(tick));
    put(out, static_cast<std::uint32_t>(removed));
    put(out, static_cast<std::uint32_t>(rows));
    return out;
}

}  // namespace

SpectatorMessage SpectatorHub::update(const SpectatorSample& sample) {
    ++samples_;
    tick_ = sample.tick;
    std::vector<const SpectatorRow*> changed;
    for (const SpectatorRow& row : sample.rows) {
        Known& known = known_[row.id];
        if (known.seen == 0 || known.row != row) {
            known.row = row;
            changed.push_back(&row);
        }
        known.seen = samples_;
    }
    std::vector<std::uint32_t> removed;
    if (known_.size() > sample.rows.size()) {
        std::erase_if(known_, [&](const auto& entry) {
            const bool gone = entry.second.seen != samples_;
            if (gone) {
                removed.push_back(entry.first);
            }
            return gone;
        });
    }
    if (changed.empty() && removed.empty()) {
        return nullptr;
    }
    everything_ = nullptr;
    std::string out = head(2, sample.tick, removed.size(), changed.size());
    for (const std::uint32_t id : removed) {
        put(out, id);
    }
    for (const SpectatorRow* row : changed) {
        put_row(out, *row);
    }
    return std::make_shared<const std::string>(std::move(out));
}

SpectatorMessage SpectatorHub::everything() {
    if (!everything_) {
        std::string out = head(1, tick_, 0, known_.size());
        for (const auto& [id, known] : known_) {
            put_row(out, known.row);
        }
        everything_ = std::make_shared<const std::string>(std::move(out));
    }
    return everything_;
}

void SpectatorHub::clear() {
    known_.clear();
    everything_ = nullptr;
    samples_ = 0;
}

}  // namespace zoned::admin
