#include "shared/wire/traffic.h"

#include "shared/wire/declared/deformation_lattice.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <utility>

namespace zoned::wire {

namespace {

constexpr int kBarCells = 24;

std::uint64_t sum(const std::array<std::uint64_t, kTrafficParts>& parts) {
    return std::accumulate(parts.begin(), parts.end(), std::uint64_t{0});
}

struct TrafficLine {
    std::string name;
    std::uint64_t bits = 0;
    std::string remark;
};

void write_traffic_lines(std::vector<TrafficLine> lines,
                         std::uint64_t all,
                         double seconds,
                         std::string& out) {
    std::stable_sort(lines.begin(), lines.end(), [](const TrafficLine& a, const TrafficLine& b) {
        return a.bits > b.bits;
    });
    for (const TrafficLine& line : lines) {
        if (line.bits == 0) {
            continue;
        }
        const double share = static_cast<double>(line.bits) / static_cast<double>(all);
        const auto cells = static_cast<std::size_t>(share * kBarCells + 0.5);
        char text[160];
        std::snprintf(text,
                      sizeof(text),
                      "  %-24s %11.0f B/s %5.1f %%  %-24s  %s\n",
                      line.name.c_str(),
                      static_cast<double>(line.bits) / 8.0 / seconds,
                      100.0 * share,
                      std::string(cells, '#').c_str(),
                      line.remark.c_str());
        out += text;
    }
}

double bytes_of(std::uint64_t bits) {
    return static_cast<double>(bits) / 8.0;
}

std::string row_name(std::size_t row, std::span<const std::string> types) {
    if (row == 0) {
        return "(no type)";
    }
    return row - 1 < types.size() ? types[row - 1] : "type " + std::to_string(row - 1);
}

/// Two objects, without zero entries.
template <typename OfReason, typename OfPart>
void write_traffic_split(core::JsonWriter& json, OfReason&& of_reason, OfPart&& of_part) {
    json.key("by_reason_bytes").begin_object();
    for (std::size_t r = 0; r < kTrafficReasons; ++r) {
        if (const std::uint64_t bits = of_reason(static_cast<TrafficReason>(r)); bits > 0) {
            json.field(kTrafficReasonNames[r], bytes_of(bits));
        }
    }
    json.end_object();
    json.key("by_field_bytes").begin_object();
    for (std::size_t p = 0; p < kTrafficParts; ++p) {
        if (const std::uint64_t bits = of_part(p); bits > 0) {
            json.field(traffic_part_name(p), bytes_of(bits));
        }
    }
    json.end_object();
}

/// The three most frequent reasons of a type's bytes, as shares.
std::string main_reasons(const TrafficTable& table, std::size_t row) {
    std::vector<std::pair<std::uint64_t, std::size_t>> reasons;
    for (std::size_t r = 0; r < kTrafficReasons; ++r) {
        reasons.emplace_back(table.bits(row, static_cast<TrafficReason>(r)), r);
    }
    std::stable_sort(reasons.begin(), reasons.end(), [](const auto& a, const auto& b) {
        return a.first > b.first;
    });
    std::string text;
    const auto all = static_cast<double>(table.bits_of_row(row));
    for (std::size_t i = 0; i < 3 && reasons[i].first > 0; ++i) {
        char part[64];
        std::snprintf(part,
                      sizeof(part),
                      "%s%s %.0f %%",
                      i > 0 ? ", " : "",
                      kTrafficReasonNames[reasons[i].second],
                      100.0 * static_cast<double>(reasons[i].first) / all);
        text += part;
    }
    return text;
}

}  // namespace

const char* traffic_part_name(std::size_t part) {
    if (part < kFields.size()) {
        return kFields[part].name;
    }
    static constexpr std::array<const char*, 6> kNames{
        "record_head", "padding", "declared_fields", "own_state", "packet_head", "code_head"};
    return kNames[part - kFields.size()];
}

TrafficTable::Row& TrafficTable::row(std::size_t index) {
    if (index >= rows_.size()) {
        rows_.resize(index + 1);
    }
    return rows_[index];
}

void TrafficTable::add_record(TypeIndex type, TrafficReason reason, const RecordBits& bits) {
    auto& parts = row(1 + static_cast<std::size_t>(type))[static_cast<std::size_t>(reason)];
    for (std::size_t i = 0; i < kRecordParts; ++i) {
        parts[i] += bits[i];
    }
}

TrafficTable::DeclaredSum& TrafficTable::declared_sum(const std::string& name) {
    for (DeclaredSum& sum : declared_) {
        if (sum.name == name) {
            return sum;
        }
    }
    return declared_.emplace_back(DeclaredSum{name, 0, 0});
}

void TrafficTable::add_declared(const FieldSchema& schema, const DeclaredBits& bits) {
    for (std::size_t i = 0; i < schema.fields().size(); ++i) {
        if (bits[i] > 0) {
            static const std::string control_points = "control_points";
            const std::string& name = schema.fields()[i].name;
            DeclaredSum& sum =
                declared_sum(name.starts_with(kControlPointName) ? control_points : name);
            sum.bits += bits[i];
            ++sum.changes;
        }
    }
}

void TrafficTable::add_removal(std::size_t bits) {
    row(0)[static_cast<std::size_t>(TrafficReason::kRemoval)][kRecordHeadPart] += bits;
}

void TrafficTable::add_packet(std::size_t head_bytes, std::size_t own_bytes) {
    Row& none = row(0);
    none[static_cast<std::size_t>(TrafficReason::kHead)][kPacketHeadPart] +=
        8 * (head_bytes - own_bytes);
    none[static_cast<std::size_t>(TrafficReason::kOwnState)][kOwnStatePart] += 8 * own_bytes;
    ++packets_;
}

void TrafficTable::add_code_head(std::size_t bits) {
    row(0)[static_cast<std::size_t>(TrafficReason::kHead)][kCodeHeadPart] += bits;
}

void TrafficTable::add_unread(std::size_t bytes) {
    row(0)[static_cast<std::size_t>(TrafficReason::kUnread)][kPaddingPart] += 8 * bytes;
}

void TrafficTable::add(const TrafficTable& other) {
    for (std::size_t i = 0; i < other.rows_.size(); ++i) {
        Row& mine = row(i);
        for (std::size_t r = 0; r < kTrafficReasons; ++r) {
            for (std::size_t p = 0; p < kTrafficParts; ++p) {
                mine[r][p] += other.rows_[i][r][p];
            }
        }
    }
    for (const DeclaredSum& theirs : other.declared_) {
        DeclaredSum& mine = declared_sum(theirs.name);
        mine.bits += theirs.bits;
        mine.changes += theirs.changes;
    }
    packets_ += other.packets_;
}

std::uint64_t TrafficTable::bits() const {
    std::uint64_t all = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        all += bits_of_row(i);
    }
    return all;
}

std::uint64_t TrafficTable::bits(TrafficReason reason) const {
    std::uint64_t all = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        all += bits(i, reason);
    }
    return all;
}

std::uint64_t TrafficTable::bits_of_part(std::size_t part) const {
    std::uint64_t all = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        all += bits_of_part(i, part);
    }
    return all;
}

std::uint64_t TrafficTable::bits_of_row(std::size_t row) const {
    std::uint64_t all = 0;
    for (const auto& parts : rows_[row]) {
        all += sum(parts);
    }
    return all;
}

std::uint64_t TrafficTable::bits(std::size_t row, TrafficReason reason) const {
    return sum(rows_[row][static_cast<std::size_t>(reason)]);
}

std::uint64_t TrafficTable::bits_of_part(std::size_t row, std::size_t part) const {
    std::uint64_t all = 0;
    for (const auto& parts : rows_[row]) {
        all += parts[part];
    }
    return all;
}

void write_traffic(core::JsonWriter& json,
                   const TrafficTable& table,
                   std::span<const std::string> types) {
    json.field("packets", table.packets());
    json.field("body_bytes", bytes_of(table.bits()));
    write_traffic_split(
        json,
        [&](TrafficReason reason) { return table.bits(reason); },
        [&](std::size_t part) { return table.bits_of_part(part); });
    if (!table.declared().empty()) {
        json.key("declared_field_bytes").begin_object();
        for (const TrafficTable::DeclaredSum& sum : table.declared()) {
            json.field(sum.name, bytes_of(sum.bits));
        }
        json.end_object();
    }
    json.key("types").begin_array();
    for (std::size_t i = 0; i < table.rows().size(); ++i) {
        if (table.bits_of_row(i) == 0) {
            continue;
        }
        json.begin_object();
        json.field("type", row_name(i, types));
        json.field("body_bytes", bytes_of(table.bits_of_row(i)));
        write_traffic_split(
            json,
            [&](TrafficReason reason) { return table.bits(i, reason); },
            [&](std::size_t part) { return table.bits_of_part(i, part); });
        json.end_object();
    }
    json.end_array();
}

std::string traffic_text(const TrafficTable& table,
                         std::span<const std::string> types,
                         double seconds,
                         std::size_t overhead_bytes) {
    const std::uint64_t overhead = 8 * overhead_bytes * table.packets();
    const std::uint64_t all = table.bits() + overhead;
    std::string out;
    if (all == 0 || !(seconds > 0.0)) {
        return out;
    }
    const TrafficLine around{"seal and headers", overhead, ""};
    std::vector<TrafficLine> lines{around};
    for (std::size_t i = 0; i < table.rows().size(); ++i) {
        lines.push_back({row_name(i, types), table.bits_of_row(i), main_reasons(table, i)});
    }
    char title[96];
    std::snprintf(title,
                  sizeof(title),
                  "state packets: %.0f B/s, %.1f packets/s\n by type, and why\n",
                  static_cast<double>(all) / 8.0 / seconds,
                  static_cast<double>(table.packets()) / seconds);
    out += title;
    write_traffic_lines(std::move(lines), all, seconds, out);
    lines.assign(1, around);
    for (std::size_t r = 0; r < kTrafficReasons; ++r) {
        lines.push_back({kTrafficReasonNames[r], table.bits(static_cast<TrafficReason>(r)), ""});
    }
    out += " by reason\n";
    write_traffic_lines(std::move(lines), all, seconds, out);
    lines.assign(1, around);
    for (std::size_t p = 0; p < kTrafficParts; ++p) {
        lines.push_back({traffic_part_name(p), table.bits_of_part(p), ""});
    }
    for (const TrafficTable::DeclaredSum& sum : table.declared()) {
        lines.push_back({"declared: " + sum.name, sum.bits, "of declared_fields"});
    }
    out += " by field\n";
    write_traffic_lines(std::move(lines), all, seconds, out);
    return out;
}

}  // namespace zoned::wire
