#include "server/replication/packer.h"
#include "shared/wire/record/record_traffic.h"

#include <algorithm>
#include <numeric>

namespace zoned::replication {

namespace {

/// Ticks' worth of time for coding that may gather.
constexpr double kCodingBurst = 4.0;

/// Head and end of coded records, about.
constexpr std::size_t kCodedHeadBytes = 6;

wire::record::CodedRecord coded_record(const Stream& stream, Tick now) {
    wire::record::CodedRecord record;
    record.entity = stream.entity;
    record.lod = stream.lod;
    record.type = stream.type;
    record.upright = stream.upright;
    // An entity that has rested for long may have done so for longer still.
    record.tick = std::max(stream.tick, now - wire::record::kOldestTicks);
    record.state = stream.state;
    return record;
}

wire::record::CodedRecord coded_removal(EntityId entity) {
    wire::record::CodedRecord record;
    record.entity = entity;
    record.remove = true;
    return record;
}

}  // namespace

void Packer::allow_coding(const mailbox::CodecPrice& price) {
    price_ = price;
    const double tick_ns = 1e3 * static_cast<double>(settings_.codec_budget_us);
    coding_ns_ = std::min(coding_ns_ + tick_ns, kCodingBurst * tick_ns);
}

/// Appends one record, or the removal of `entity` where it is of no stream.
bool Packer::add_coded(Tick now,
                       EntityId entity,
                       const Stream* stream,
                       std::uint32_t declared_bytes,
                       double allowed_bytes,
                       const ClientState& client) {
    // How many bytes its state takes is known when the packet is coded. Fields are not compressed.
    const std::size_t guess =
        static_cast<std::size_t>(client.coded_bytes * static_cast<float>(coded_.size() + 1)) +
        std::accumulate(
            declared_bytes_.begin(), declared_bytes_.end(), std::size_t{declared_bytes});
    if (coded_.size() == wire::record::kMostRecords ||
        !fits(body_.size() + kCodedHeadBytes + guess, allowed_bytes)) {
        return false;
    }
    coded_.push_back(stream != nullptr ? coded_record(*stream, now) : coded_removal(entity));
    declared_bytes_.push_back(declared_bytes);
    return true;
}

/// Counts the coded records once their whole packet is coded: their sizes are known only then.
void Packer::count_coded(const wire::record::RecordFrame& frame) {
    wire::record::add_traffic(
        meter_->table(),
        frame,
        body_.size() - head_bytes_,
        settings_.fields,
        [&](const auto& record) {
            return std::find_if(reasons_.begin(),
                                reasons_.end(),
                                [&](const auto& reason) { return reason.first == record.entity; })
                ->second;
        });
}

/// Codes the gathered records, in several packets where they take more bytes than was guessed.
void Packer::finish_coded(Tick now,
                          ClientState& client,
                          const StreamTable& streams,
                          ReplicationReport& report,
                          std::vector<mailbox::StatePacket>& out) {
    // Writing a packet in between empties coded_ and entries_.
    coding_.swap(coded_);
    coding_entries_.swap(entries_);
    coding_declared_.swap(declared_bytes_);
    const std::span<const wire::record::CodedRecord> records = coding_;
    std::size_t done = 0;
    while (done < records.size()) {
        head_.coded = true;
        std::size_t count = records.size() - done;
        std::shared_ptr<const wire::record::RecordFrame> frame;
        for (;; count = (3 * count + 3) / 4) {
            body_.clear();
            wire::write_down_head(head_, body_);
            head_bytes_ = body_.size();
            frame = client.coder->encode(
                static_cast<wire::entropy::PacketNumber>(client.next_sequence()),
                now,
                head_.zone,
                records.subspan(done, count),
                body_,
                meter_ != nullptr,
                &streams);
            const auto first = coding_declared_.begin() + static_cast<std::ptrdiff_t>(done);
            const std::size_t fields =
                std::accumulate(first, first + static_cast<std::ptrdiff_t>(count), std::size_t{0});
            const std::size_t all = body_.size() - head_bytes_;
            const auto size = static_cast<float>(all - std::min(all, fields));
            client.coded_bytes += (size / static_cast<float>(count) - client.coded_bytes) / 8.0F;
            if (body_.size() <= wire::kMaxDownBodyBytes) {
                break;
            }
        }
        if (meter_) {
            count_coded(*frame);
        }
        client.coder->sent(std::move(frame));
        const auto first = coding_entries_.begin() + static_cast<std::ptrdiff_t>(done);
        entries_.assign(first, first + static_cast<std::ptrdiff_t>(count));
        send(now, client, report, out);
        done += count;
        begin(now, head_.zone, nullptr);
    }
    reasons_.clear();
}

}  // namespace zoned::replication
