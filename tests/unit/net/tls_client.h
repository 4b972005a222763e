// TlsClient: a blocking TLS 1.3 client for tests. It has a thread of its own, so that the listener
// can run in another.
#pragma once

#include "shared/wire/seal.h"

#include <asio/connect.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/ssl.hpp>
#include <asio/write.hpp>
#include <openssl/ssl.h>

#include <array>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

namespace zoned::net {

class TlsClient {
  public:
    TlsClient() : context_(asio::ssl::context::tls_client), stream_(io_, context_) {}

    /// False when connection or handshake fail; `error` then says why. The handshake begins after
    /// `hesitation`.
    bool connect(std::uint16_t port,
                 const std::string& host = "127.0.0.1",
                 std::chrono::milliseconds hesitation = {}) {
        stream_.next_layer().connect({asio::ip::make_address(host), port}, error);
        std::this_thread::sleep_for(hesitation);
        if (!error) {
            stream_.handshake(asio::ssl::stream_base::client, error);
        }
        return !error;
    }

    void allow_at_most(int version) { SSL_set_max_proto_version(stream_.native_handle(), version); }

    /// The first message of a handshake.
    static std::string client_hello() {
        asio::ssl::context context(asio::ssl::context::tls_client);
        SSL* ssl = SSL_new(context.native_handle());
        BIO* out = BIO_new(BIO_s_mem());
        SSL_set_bio(ssl, BIO_new(BIO_s_mem()), out);
        SSL_connect(ssl);
        char* bytes = nullptr;
        const auto count = static_cast<std::size_t>(BIO_get_mem_data(out, &bytes));
        std::string hello(bytes, count);
        SSL_free(ssl);
        return hello;
    }

    std::string fingerprint() {
        X509* certificate = SSL_get1_peer_certificate(stream_.native_handle());
        std::array<unsigned char, 32> digest{};
        X509_digest(certificate, EVP_sha256(), digest.data(), nullptr);
        X509_free(certificate);
        std::string out;
        for (const unsigned char b : digest) {
            constexpr char kDigits[] = "0123456789abcdef";
            out.push_back(kDigits[b >> 4]);
            out.push_back(kDigits[b & 15]);
        }
        return out;
    }

    void send_raw(const std::string& bytes) { asio::write(stream_, asio::buffer(bytes), error); }

    void send(const std::string& payload) { send_raw(prefix(payload.size()) + payload); }

    static std::string prefix(std::size_t length) {
        std::string out(4, '\0');
        for (std::size_t i = 0; i < 4; ++i) {
            out[i] = static_cast<char>(length >> (8 * i));
        }
        return out;
    }

    /// The next frame; empty and `error` set when the stream ended.
    std::string receive() {
        std::array<unsigned char, 4> head{};
        asio::read(stream_, asio::buffer(head), error);
        if (error) {
            return {};
        }
        const std::size_t length =
            head[0] | (head[1] << 8) | (head[2] << 16) | (static_cast<unsigned>(head[3]) << 24);
        std::string payload(length, '\0');
        asio::read(stream_, asio::buffer(payload), error);
        return payload;
    }

    void close() { stream_.shutdown(error); }

    void vanish() { stream_.next_layer().close(); }

    asio::error_code error;

  private:
    asio::io_context io_;
    asio::ssl::context context_;
    asio::ssl::stream<asio::ip::tcp::socket> stream_;
};

}  // namespace zoned::net
