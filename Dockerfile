FROM python:3.12-slim
COPY . /photonmap
RUN pip install --no-cache-dir -c /photonmap/constraints.txt /photonmap
# Kernels for every x86-64 processor since 2013, compiled once; those of --unbiased when first used.
ENV NUMBA_CACHE_DIR=/opt/photonmap-kernels NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES=
RUN photonmap compile --quiet && chmod -R a+rwX /opt/photonmap-kernels
WORKDIR /work
ENTRYPOINT ["photonmap"]
