#include "server/net/certificate.h"

#include "shared/core/files/replace_file.h"
#include "shared/core/hex.h"

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace zoned::net {

namespace {

template <auto Free>
struct Deleter {
    template <class T>
    void operator()(T* p) const {
        Free(p);
    }
};

using Key = std::unique_ptr<EVP_PKEY, Deleter<EVP_PKEY_free>>;
using X509Ptr = std::unique_ptr<X509, Deleter<X509_free>>;
using Bio = std::unique_ptr<BIO, Deleter<BIO_free_all>>;

constexpr long kValidSeconds = 10L * 365 * 24 * 3600;

[[noreturn]] void fail(const std::string& what) {
    const unsigned long code = ERR_get_error();
    std::array<char, 160> reason{};
    if (code != 0) {
        ERR_error_string_n(code, reason.data(), reason.size());
    }
    ERR_clear_error();
    throw std::runtime_error(code == 0 ? what : what + " [" + reason.data() + "]");
}

void add_extension(X509* certificate, int nid, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx_nodb(&context);
    X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
    X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, nid, value);
    if (extension == nullptr || X509_add_ext(certificate, extension, -1) != 1) {
        X509_EXTENSION_free(extension);
        fail("cannot make a certificate");
    }
    X509_EXTENSION_free(extension);
}

X509Ptr self_signed(EVP_PKEY* key) {
    X509Ptr certificate(X509_new());
    std::array<std::uint8_t, 16> serial{};
    if (!certificate || RAND_bytes(serial.data(), serial.size()) != 1) {
        fail("cannot make a certificate");
    }
    serial[0] &= 0x7F;  // serial numbers are positive (RFC 5280, section 4.1.2.2)
    const std::unique_ptr<BIGNUM, Deleter<BN_free>> number(
        BN_bin2bn(serial.data(), serial.size(), nullptr));
    BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate.get()));
    X509_set_version(certificate.get(), X509_VERSION_3);
    // A day back: clocks of clients may be behind.
    X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -24L * 3600);
    X509_gmtime_adj(X509_getm_notAfter(certificate.get()), kValidSeconds);
    X509_set_pubkey(certificate.get(), key);
    X509_NAME* name = X509_get_subject_name(certificate.get());
    const auto* common_name = reinterpret_cast<const unsigned char*>("zoned development");
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, common_name, -1, -1, 0);
    X509_set_issuer_name(certificate.get(), name);
    add_extension(certificate.get(), NID_basic_constraints, "critical,CA:FALSE");
    add_extension(certificate.get(), NID_ext_key_usage, "serverAuth");
    add_extension(
        certificate.get(), NID_subject_alt_name, "DNS:localhost,IP:127.0.0.1,IP:0:0:0:0:0:0:0:1");
    if (X509_sign(certificate.get(), key, EVP_sha256()) == 0) {
        fail("cannot sign a certificate");
    }
    return certificate;
}

void write_private(const std::string& path, BIO* content) {
    char* data = nullptr;
    const long size = BIO_get_mem_data(content, &data);
    const auto written =
        core::replace_file(path, std::string_view(data, static_cast<std::size_t>(size)), 0600);
    if (!written) {
        fail(written.error() +
             "; make the state folder writable, or configure certificate and key files");
    }
}

void make_pair(const CertificateFiles& files) {
    const Key key(EVP_EC_gen("P-256"));
    if (!key) {
        fail("cannot make a P-256 key");
    }
    const X509Ptr certificate = self_signed(key.get());
    const Bio key_text(BIO_new(BIO_s_mem()));
    const Bio certificate_text(BIO_new(BIO_s_mem()));
    if (PEM_write_bio_PrivateKey(
            key_text.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1 ||
        PEM_write_bio_X509(certificate_text.get(), certificate.get()) != 1) {
        fail("cannot encode the certificate");
    }
    write_private(files.key, key_text.get());
    write_private(files.certificate, certificate_text.get());
}

void require_readable(const std::string& path, const std::string& what) {
    if (::access(path.c_str(), R_OK) != 0) {
        const bool missing = errno == ENOENT || errno == ENOTDIR;
        throw std::runtime_error("the " + what + " file " + path +
                                 (missing
                                      ? " does not exist: correct its path in the config, or "
                                        "leave both files out for a self-signed certificate"
                                      : std::string(" cannot be read (") + std::strerror(errno) +
                                            "): give the server's user the right to"));
    }
}

}  // namespace

CertificateFiles prepare_certificate(const CertificateSettings& settings) {
    CertificateFiles files;
    if (!settings.certificate_file.empty() || !settings.key_file.empty()) {
        if (settings.certificate_file.empty() || settings.key_file.empty()) {
            throw std::runtime_error(
                "a certificate file and a key file must be configured "
                "together, or neither for a self-signed certificate");
        }
        files.certificate = settings.certificate_file;
        files.key = settings.key_file;
        return files;
    }
    files.self_signed = true;
    const std::filesystem::path dir = settings.state_dir;
    files.certificate = (dir / "certificate.pem").string();
    files.key = (dir / "key.pem").string();
    std::error_code ec;
    std::filesystem::create_directories(dir, ec);
    if (ec) {
        throw std::runtime_error("cannot make the state folder " + dir.string() + ": " +
                                 ec.message() + "; configure one that the server may write to");
    }
    const bool have_certificate = std::filesystem::exists(files.certificate, ec);
    const bool have_key = std::filesystem::exists(files.key, ec);
    if (have_certificate && !have_key) {
        throw std::runtime_error("the state folder " + dir.string() +
                                 " holds certificate.pem but not key.pem: delete certificate.pem "
                                 "to have a new pair made");
    }
    // The key is written first: an interrupted first start leaves only a key behind.
    if (!have_certificate) {
        make_pair(files);
    }
    return files;
}

asio::ssl::context make_server_context(const CertificateFiles& files) {
    require_readable(files.certificate, "certificate");
    require_readable(files.key, "key");
    ERR_clear_error();
    asio::ssl::context context(asio::ssl::context::tls_server);
    SSL_CTX* native = context.native_handle();
    SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
    // Sessions of zoned resume by their own token; TLS tickets would be work for nothing.
    SSL_CTX_set_num_tickets(native, 0);
    SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
    SSL_CTX_set_mode(native, SSL_MODE_RELEASE_BUFFERS);
    if (SSL_CTX_use_certificate_chain_file(native, files.certificate.c_str()) != 1) {
        fail("the file " + files.certificate + " holds no certificate in PEM form");
    }
    // OpenSSL compares the key with the certificate as it loads: tell the two mistakes apart.
    const Bio key_file(BIO_new_file(files.key.c_str(), "r"));
    const Key key(key_file ? PEM_read_bio_PrivateKey(key_file.get(), nullptr, nullptr, nullptr)
                           : nullptr);
    if (!key) {
        fail("the file " + files.key + " holds no private key in PEM form");
    }
    if (SSL_CTX_use_PrivateKey(native, key.get()) != 1 || SSL_CTX_check_private_key(native) != 1) {
        fail("the key in " + files.key + " does not belong to the certificate in " +
             files.certificate + ": configure the pair that was issued together");
    }
    return context;
}

std::string certificate_fingerprint(asio::ssl::context& context) {
    X509* certificate = SSL_CTX_get0_certificate(context.native_handle());
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    if (certificate == nullptr ||
        X509_digest(certificate, EVP_sha256(), digest.data(), &size) != 1) {
        fail("the certificate has no fingerprint");
    }
    return core::to_hex({digest.data(), size});
}

}  // namespace zoned::net
