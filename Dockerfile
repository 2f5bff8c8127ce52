FROM python:3.12-slim
COPY . /photonmap
RUN pip install --no-cache-dir -c /photonmap/constraints.txt /photonmap
ENV NUMBA_CACHE_DIR=/tmp/photonmap-kernels
WORKDIR /work
ENTRYPOINT ["photonmap"]
