"""Writes a recording of palpate anew, as the MCAP library for Python does: one file for each way.

    python3 -m venv venv && venv/bin/pip install mcap==1.6.0 lz4 zstandard
    venv/bin/python others.py RECORDING.mcap

RECORDING.mcap is what `small(true)` in tests/recording/common.rs writes (the test `write_small`).
"""

import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

WAYS = {
    "plain": dict(compression=CompressionType.NONE),
    "lz4": dict(compression=CompressionType.LZ4),
    "zstd": dict(compression=CompressionType.ZSTD),
    "unchunked": dict(use_chunking=False),
    "metadata-last": dict(compression=CompressionType.ZSTD),
}


def main(source):
    for name, options in WAYS.items():
        with open(source, "rb") as recording, open(Path(__file__).parent / f"{name}.mcap", "wb") as out:
            reader = make_reader(recording)
            messages = list(reader.iter_messages(log_time_order=False))
            metadata = list(reader.iter_metadata())
            # Small chunks, so that there are several.
            writer = Writer(out, chunk_size=700, **options)
            writer.start()
            if name != "metadata-last":
                for metadata in metadata:
                    writer.add_metadata(metadata.name, metadata.metadata)
            channels = {}
            for schema, channel, message in messages:
                if channel.id not in channels:
                    known = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.id] = writer.register_channel(
                        channel.topic, channel.message_encoding, known
                    )
                writer.add_message(
                    channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence
                )
            if name == "metadata-last":
                for metadata in metadata:
                    writer.add_metadata(metadata.name, metadata.metadata)
            writer.finish()


main(sys.argv[1])
