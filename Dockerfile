# The command and its page: docker build -t roughcontact . && docker run --rm -it --network host roughcontact
# The tests: docker build -t roughcontact-tests --target tests . && docker run --rm roughcontact-tests
FROM python:3.11-slim AS installed

# Pictures are drawn without a display; what matplotlib finds out is kept where any user may write.
ENV MPLCONFIGDIR=/tmp/matplotlib PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore
RUN useradd --create-home --uid 1000 contact && mkdir /maps && chown contact /maps
COPY . /opt/roughcontact
WORKDIR /opt/roughcontact
# Dependency groups, which the tests need, are known to pip from 25.1 on.
RUN pip install --upgrade 'pip>=25.1' && pip install '.[cli,store,table,flow,files]' ./plugins/roughcontact-app

FROM installed AS tests

RUN pip install --group test && chown -R contact /opt/roughcontact
USER contact
ENTRYPOINT ["pytest"]
CMD ["-q", "-n", "2"]

FROM installed

USER contact
WORKDIR /maps
ENTRYPOINT ["roughcontact"]
# The page listens on 127.0.0.1 alone, which is that of the host with --network host.
CMD ["app", "--port", "8000", "--no-browser"]
