// Snapshot codec: whole snapshots for one client in few bits, told from what that client has
// acknowledged alone.
#pragma once

#include "shared/core/result.h"
#include "shared/wire/snapshot/knowledge.h"
#include "shared/wire/snapshot/neighbours.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

namespace zoned::wire::snapshot {

/// Codes snapshots exactly, each against the newest ones that the receiver has acknowledged:
/// predicted from their motion (velocity over several lags, turn rate, what happened to neighbours
/// that are coded already, weights learned by least squares), residuals by an adaptive range coder.
/// Predictors and probabilities are trained on acknowledged snapshots only, in ascending order, so
/// any packet may be lost, doubled or late. After R. Giesen's contest entry (adaptive models
/// inherited from the acknowledged baseline, 2015), which has neither neighbours nor least squares
/// and trains on one snapshot in as many as are under way.
class SnapshotEncoder {
  public:
    explicit SnapshotEncoder(const SnapshotFormat& format);

    /// Appends the code of snapshot `number` (ascending from 1) to `out`. Samples must be within
    /// the format; one per body.
    void encode(FrameNumber number, const Snapshot& samples, std::vector<std::uint8_t>& out);

    /// The receiver has decoded this snapshot. Unknown, old and repeated numbers are ignored.
    void acknowledge(FrameNumber number);

    /// A snapshot that the receiver got in another way (at login); before the first encode().
    void share(FrameNumber number, const Snapshot& samples);

    /// Snapshots under way that can still be acknowledged.
    static constexpr std::size_t kUnderWay = 64;

  private:
    struct Sent {
        std::shared_ptr<CodedFrame> frame;
        FrameNumber reference = 0;  // newest that the receiver knew when it decoded this one
        std::uint8_t epoch = 0;
        bool acknowledged = false;
    };

    void learn_acknowledged();
    void start_over();

    SnapshotFormat format_;
    Knowledge knowledge_;
    std::uint8_t epoch_ = 0;  // counts how often knowledge began anew
    Neighbours neighbours_;   // of the pass
    FramePool frames_;
    std::deque<Sent> sent_;  // ascending
};

class SnapshotDecoder {
  public:
    explicit SnapshotDecoder(const SnapshotFormat& format);

    /// Decodes snapshot `number`. Bytes are hostile: fails with the reason when they are malformed
    /// or refer to what is not known (any more); nothing is changed then. What was decoded must be
    /// acknowledged to the encoder, what was not must not.
    /// The samples stay valid until the next decode().
    core::Result<const Snapshot*> decode(FrameNumber number, std::span<const std::uint8_t> bytes);

    void share(FrameNumber number, const Snapshot& samples);

  private:
    [[nodiscard]] std::deque<FramePointer>::iterator find_received(FrameNumber number);
    const Snapshot* keep(std::shared_ptr<CodedFrame> frame);
    [[nodiscard]] const Knowledge* knowledge_at(FrameNumber newest, std::uint64_t learned);

    static constexpr std::size_t kReceived = 128;
    /// Packets may overtake each other by so many states of knowledge.
    static constexpr std::size_t kReordered = 16;

    SnapshotFormat format_;
    std::uint8_t epoch_ = 0;
    FrameNumber newest_ = 0;  // received
    Neighbours neighbours_;   // of the pass
    FramePool frames_;
    std::deque<FramePointer> received_;  // ascending
    std::deque<Knowledge> known_;        // ascending by newest()
};

}  // namespace zoned::wire::snapshot
