// AddressProof: whether a client has shown that it receives at the address that it sends from.
#pragma once

#include <cstddef>
#include <cstdint>

namespace zoned::session {

/// Whoever holds a session's keys can send from an address that is not its own, and the server's
/// states would flood whoever is there. So at most kMostPerByte times as many bytes go to an
/// address as came from it, until a packet that went there is acknowledged (RFC 9000, sections 8.1
/// and 9.3.1). A client that guesses acknowledgements has to go on sending for each of them.
class AddressProof {
  public:
    static constexpr std::uint64_t kMostPerByte = 3;

    /// Another address from now on. `proved`: the client is known to receive there, as its stream's
    /// handshake came from the same host.
    void begin(bool proved) { *this = AddressProof(proved); }

    /// A datagram came from there.
    void take(std::size_t bytes) { taken_ += bytes; }

    [[nodiscard]] bool may_send(std::size_t bytes) const {
        return proved_ || sent_ + bytes <= kMostPerByte * taken_;
    }

    /// A packet goes there.
    void send(std::uint64_t sequence, std::size_t bytes) {
        first_ = sent_ == 0 ? sequence : first_;
        sent_ += bytes;
    }

    /// The newest packet that the client says it has.
    void acknowledge(std::uint64_t newest) { proved_ = proved_ || (sent_ > 0 && newest >= first_); }

    AddressProof() = default;

  private:
    explicit AddressProof(bool proved) : proved_(proved) {}

    bool proved_ = false;
    std::uint64_t taken_ = 0;
    std::uint64_t sent_ = 0;
    std::uint64_t first_ = 0;  ///< sequence of the first packet that went there
};

}  // namespace zoned::session
