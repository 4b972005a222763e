// Snapshot codec: whole snapshots for one client in few bits, told from what that client has
// acknowledged alone.
// Reached by no program yet: recordings, and worlds in which a client hears every state, will use
// it.
#pragma once

#include "shared/core/result.h"
#include "shared/wire/snapshot/knowledge.h"
#include "shared/wire/snapshot/neighbours.h"

#include <cstdint>
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

  private:
    SnapshotFormat format_;
    entropy::KnowledgeEncoder<Knowledge> acknowledged_;
    Neighbours neighbours_;  // of the pass
    entropy::FramePool<CodedFrame> frames_;
    std::vector<std::uint8_t> raw_;  // scratch of the range coder
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
    SnapshotFormat format_;
    entropy::KnowledgeDecoder<Knowledge> acknowledged_;
    Neighbours neighbours_;  // of the pass
    entropy::FramePool<CodedFrame> frames_;
};

}  // namespace zoned::wire::snapshot
