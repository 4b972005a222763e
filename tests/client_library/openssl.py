"""TLS 1.3 and AES-128-GCM of OpenSSL 3."""

import ctypes
import hashlib
import socket

SSL = ctypes.CDLL("libssl.so.3")
CRYPTO = ctypes.CDLL("libcrypto.so.3")
POINTER, INT = ctypes.c_void_p, ctypes.c_int

CTRL_MODE, CTRL_MIN_VERSION = 33, 123
TLS_1_3 = 0x0304
PARTIAL_WRITE, MOVING_BUFFER = 1, 2
WANTS_READ, WANTS_WRITE = 2, 3
GCM_GET_TAG, GCM_SET_TAG = 0x10, 0x11
TAG_BYTES = 16


def declare(library, name, result, *arguments):
    """A function with its types."""
    function = getattr(library, name)
    function.restype, function.argtypes = result, arguments
    return function


TLS_METHOD = declare(SSL, "TLS_client_method", POINTER)
CONTEXT_NEW = declare(SSL, "SSL_CTX_new", POINTER, POINTER)
CONTEXT_FREE = declare(SSL, "SSL_CTX_free", None, POINTER)
CONTEXT_CTRL = declare(SSL, "SSL_CTX_ctrl", ctypes.c_long, POINTER, INT, ctypes.c_long, POINTER)
NEW = declare(SSL, "SSL_new", POINTER, POINTER)
FREE = declare(SSL, "SSL_free", None, POINTER)
SET_FD = declare(SSL, "SSL_set_fd", INT, POINTER, INT)
CONNECT = declare(SSL, "SSL_connect", INT, POINTER)
READ = declare(SSL, "SSL_read", INT, POINTER, POINTER, INT)
WRITE = declare(SSL, "SSL_write", INT, POINTER, ctypes.c_char_p, INT)
GET_ERROR = declare(SSL, "SSL_get_error", INT, POINTER, INT)
SHUTDOWN = declare(SSL, "SSL_shutdown", INT, POINTER)
PEER_CERTIFICATE = declare(SSL, "SSL_get1_peer_certificate", POINTER, POINTER)
CERTIFICATE_FREE = declare(CRYPTO, "X509_free", None, POINTER)
CERTIFICATE_DER = declare(CRYPTO, "i2d_X509", INT, POINTER, POINTER)
CLEAR_ERRORS = declare(CRYPTO, "ERR_clear_error", None)
GCM = declare(CRYPTO, "EVP_aes_128_gcm", POINTER)
CIPHER_NEW = declare(CRYPTO, "EVP_CIPHER_CTX_new", POINTER)
CIPHER_FREE = declare(CRYPTO, "EVP_CIPHER_CTX_free", None, POINTER)
CIPHER_CTRL = declare(CRYPTO, "EVP_CIPHER_CTX_ctrl", INT, POINTER, INT, INT, POINTER)
CIPHER_INIT = declare(CRYPTO, "EVP_CipherInit_ex", INT, POINTER, POINTER, POINTER, ctypes.c_char_p, ctypes.c_char_p,
                      INT)
CIPHER_UPDATE = declare(CRYPTO, "EVP_CipherUpdate", INT, POINTER, POINTER, POINTER, ctypes.c_char_p, INT)
CIPHER_FINAL = declare(CRYPTO, "EVP_CipherFinal_ex", INT, POINTER, POINTER, POINTER)


class TlsStream:
    """A connection to one server, which does not wait once it stands."""

    def __init__(self, host, port, certificate_sha256=None):
        self.socket = socket.create_connection((host, port), 10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.settimeout(None)
        self.context = CONTEXT_NEW(TLS_METHOD())
        CONTEXT_CTRL(self.context, CTRL_MIN_VERSION, TLS_1_3, None)
        CONTEXT_CTRL(self.context, CTRL_MODE, PARTIAL_WRITE | MOVING_BUFFER, None)
        self.ssl = NEW(self.context)
        SET_FD(self.ssl, self.socket.fileno())
        if CONNECT(self.ssl) != 1:
            self.cut()
            raise ConnectionError("the TLS handshake failed")
        if certificate_sha256 and self.certificate_sha256() != certificate_sha256:
            self.cut()
            raise ConnectionError("the certificate is not the pinned one")
        self.socket.setblocking(False)
        self.waiting = b""
        self.buffer = ctypes.create_string_buffer(65536)

    def certificate_sha256(self):
        """Digest of the server's certificate."""
        certificate = PEER_CERTIFICATE(self.ssl)
        der = ctypes.create_string_buffer(CERTIFICATE_DER(certificate, None))
        CERTIFICATE_DER(certificate, ctypes.byref(ctypes.c_void_p(ctypes.addressof(der))))
        CERTIFICATE_FREE(certificate)
        return hashlib.sha256(der.raw).digest()

    def read(self):
        """All that has come; a ConnectionError at the end of the stream."""
        parts = []
        while True:
            CLEAR_ERRORS()
            count = READ(self.ssl, self.buffer, len(self.buffer))
            if count > 0:
                parts.append(self.buffer.raw[:count])
                continue
            if GET_ERROR(self.ssl, count) in (WANTS_READ, WANTS_WRITE) or parts:
                return b"".join(parts)
            raise ConnectionError("the server closed the stream")

    def write(self, data=b""):
        """Sends, as far as the socket takes it; the rest goes with the next call."""
        self.waiting += data
        while self.waiting:
            CLEAR_ERRORS()
            count = WRITE(self.ssl, self.waiting, len(self.waiting))
            if count <= 0:
                if GET_ERROR(self.ssl, count) in (WANTS_READ, WANTS_WRITE):
                    return
                raise ConnectionError("the server closed the stream")
            self.waiting = self.waiting[count:]

    def cut(self):
        """Ends the connection as a broken network would, without a word."""
        self.socket.close()
        self.free()

    def close(self):
        """Ends the connection in good order."""
        CLEAR_ERRORS()
        SHUTDOWN(self.ssl)
        self.cut()

    def free(self):
        """Memory of OpenSSL."""
        FREE(self.ssl)
        CONTEXT_FREE(self.context)
        self.ssl = self.context = None


def seal(key, nonce, head, plain):
    """AES-128-GCM: the sealed bytes and their tag."""
    return run_gcm(key, nonce, head, plain, None)


def unseal(key, nonce, head, sealed):
    """The plain bytes; None where the tag is another."""
    return run_gcm(key, nonce, head, sealed[:-TAG_BYTES], sealed[-TAG_BYTES:])


def run_gcm(key, nonce, head, data, tag):
    """Seals without a tag, opens with one."""
    context, count = CIPHER_NEW(), ctypes.c_int()
    out, made = ctypes.create_string_buffer(len(data) + TAG_BYTES), ctypes.create_string_buffer(tag or b"", TAG_BYTES)
    try:
        CIPHER_INIT(context, GCM(), None, key, nonce, 0 if tag else 1)
        CIPHER_UPDATE(context, None, ctypes.byref(count), head, len(head))
        CIPHER_UPDATE(context, out, ctypes.byref(count), data, len(data))
        if tag:
            CIPHER_CTRL(context, GCM_SET_TAG, TAG_BYTES, made)
        good = CIPHER_FINAL(context, ctypes.create_string_buffer(TAG_BYTES), ctypes.byref(count))
        if tag:
            return out.raw[:len(data)] if good == 1 else None
        CIPHER_CTRL(context, GCM_GET_TAG, TAG_BYTES, made)
        return out.raw[:len(data)] + made.raw
    finally:
        CIPHER_FREE(context)
