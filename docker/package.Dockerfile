# The Debian packages, built where no Debian 12 is at hand. From the repository root:
#   docker build -f docker/package.Dockerfile --output build/package .
ARG BASE=debian:bookworm-slim
FROM ${BASE} AS build
WORKDIR /src
COPY config/packages.txt config/packages.txt
RUN apt-get update -q \
    && sed -e 's/#.*//' -e '/^[[:space:]]*$/d' config/packages.txt \
       | DEBIAN_FRONTEND=noninteractive xargs apt-get install -q -y --no-install-recommends
COPY . .
RUN cmake -S . -B /build -G Ninja -DCMAKE_CXX_COMPILER=clang++-19 -DZONED_TESTS=OFF -DZONED_UNITY=ON \
    && cmake --build /build --target package \
    && mkdir /out && cp /build/zoned_*.deb /build/zoned-dev_*.deb /out/

FROM scratch
COPY --from=build /out/ /
